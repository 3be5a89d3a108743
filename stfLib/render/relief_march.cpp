// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/relief_march.h"

#include "stfLib/render/surface_crossing.h"
#include "stfLib/render/surface_point.h"

namespace stf {

namespace {

/// Interfaces that a path meets for certain; beyond, roulette decides, and none meets more than kMostMeetings.
constexpr int kFreeMeetings = 8, kMostMeetings = 64;
constexpr float kGoOn = 0.75f;
/// What is mirrored and counts for less than this meets the relief again only with the chance that makes up for it.
constexpr float kFaint = 0.25f;

Vec3f voxelsPerMm(const TileMedium& medium) {
    const Vec3d& mm = medium.voxelMm();
    return {float(1 / mm.x), float(1 / mm.y), float(1 / mm.z)};
}

} // namespace

ReliefMarch::ReliefMarch(const ShellObject& object, ShellProbe& probe, TileMarch& tile, const Rgb* core, int level,
                         const ShellLight* lights, int lightCount, PixelSampler& sampler)
    : object_(object), probe_(probe), tile_(tile), core_(core), level_(level), step_(object.marchStep(level)),
      perMm_(voxelsPerMm(*object.medium)), lights_(lights, lightCount), sampler_(sampler) {}

// Roulette on paths that are caught, or hardly count. False where the path ends.
bool ReliefMarch::survives(Path& path) {
    if (path.faint) {
        path.faint = false;
        if (const float chance = maxComponent(tile_.transmittance()) / kFaint; chance < 1) {
            if (!(sampler_.next1d() < chance)) {
                return false;
            }
            tile_.pass(1 / chance);
        }
    }
    if (++path.meetings > kMostMeetings) {
        return false;
    }
    if (path.meetings > kFreeMeetings) {
        if (!(sampler_.next1d() < kGoOn)) {
            return false;
        }
        tile_.pass(1 / kGoOn);
    }
    return true;
}

// An interface with its normals out of the material. The first one splits the path, at others chance decides. False
// where the path ends.
bool ReliefMarch::meet(Path& path, const Vec3f& normal, const Vec3f& facet, float ior) {
    if (!survives(path)) {
        return false;
    }
    // Radiance over n^2 is what an interface leaves as it is but for Fresnel's share.
    const float across = path.inside ? ior * ior : 1 / (ior * ior), side = path.inside ? -1.0f : 1.0f;
    const bool first = splits_ && !path.inside;
    splits_ = splits_ && !first;
    if (!(dot(path.direction, facet) * side < 0)) {
        // The path was carried across between two pieces: no interface faces it here.
        tile_.pass(across);
        path.inside = !path.inside;
        return true;
    }
    const SurfaceCrossing crossing =
        crossSurface(path.direction, normal * side, facet * side, path.inside ? 1 / ior : ior);
    bool reflects = false;
    if (first) {
        mirrors_ = crossing.reflectance > 0;
        mirrorWeight_ = tile_.transmittance() * crossing.reflectance;
        mirror_ = path;
        mirror_.direction = crossing.reflected;
        mirror_.faint = true;
        if (!(crossing.reflectance < 1)) {
            return false;
        }
        tile_.pass(1 - crossing.reflectance);
    } else {
        reflects = sampler_.next1d() < crossing.reflectance;
    }
    path.direction = reflects ? crossing.reflected : crossing.refracted;
    if (!reflects) {
        tile_.pass(across);
        path.inside = !path.inside;
    }
    return true;
}

// Looks up where the ray enters; false where the path ends there.
bool ReliefMarch::start(const ReliefEntry& entry, Path& path) {
    path.origin = entry.point;
    path.direction = entry.direction;
    path.onTop = true;
    const float middle = 0.5f * step_;
    if (!path.place.find(probe_, entry.point + entry.direction * middle, core_, level_)) {
        return true; // a sliver at the rim that the grid does not hold
    }
    path.place.known = path.bent = true;
    path.place.enterHere(entry.direction, middle, step_, object_.mmPerUnit);
    Vec3f top = path.place.tilePosition(entry.point, perMm_, object_.mmPerUnit);
    top.z = 0;
    return !tile_.insideRelief(top) || meet(path, entry.normal, normalize(entry.facet), tile_.iorAt(top));
}

void ReliefMarch::startWithin(const ReliefEntry& entry, Path& path) {
    path.origin = entry.point;
    path.direction = entry.direction;
    splits_ = false;
    if (path.place.find(probe_, entry.point, core_, level_)) {
        path.place.known = path.bent = true;
        path.inside = tile_.insideRelief(path.place.tilePosition(entry.point, perMm_, object_.mmPerUnit));
    }
}

// Piece by piece along a straight way until it meets the relief.
ReliefMarch::Leg ReliefMarch::walkStraight(Path& path, float tEnd, ReliefMeeting& met) {
    const float mmPerUnit = object_.mmPerUnit;
    ShellPlace& place = path.place;
    for (float t0 = 0, t1 = 0; t0 < tEnd; t0 = t1) {
        // Where the way has just been bent the last lookup serves a while longer: nothing jumps there.
        t1 = std::min(t0 + (path.bent ? 0.5f * step_ : step_), tEnd);
        const Vec3f start = path.origin + path.direction * t0;
        if (!path.bent) {
            const Vec3f point = path.origin + path.direction * (0.5f * (t0 + t1));
            if (!place.find(probe_, point, core_, level_)) {
                if (!place.known) {
                    continue;
                }
                place.carry(point - place.point, 1, mmPerUnit);
            } else if (!place.known) {
                // The entry was a sliver: what lies behind it is met without an interface.
                place.known = true;
                if (const Vec3f at = place.tilePosition(start, perMm_, mmPerUnit); tile_.insideRelief(at)) {
                    const float ior = tile_.iorAt(at);
                    tile_.pass(1 / (ior * ior));
                    path.inside = true;
                }
            }
            if (t1 < tEnd) {
                probe_.prefetch(point + path.direction * step_, level_);
            }
        }
        path.bent = false;
        if (path.inside) {
            lights_.setFrame(place.at, path.direction, tile_);
        }
        TileLine line = place.lineAlong(path.direction, 0, perMm_, mmPerUnit);
        line.position = place.tilePosition(start, perMm_, mmPerUnit);
        switch (tile_.segmentToRelief(line.position, line.voxelsPerMm, (t1 - t0) * mmPerUnit, path.inside, met,
                                      place.at.coreRadiance)) {
        case TileMarch::Segment::Ended:
            return Leg::Ended;
        case TileMarch::Segment::Met: {
            const float t = t0 + met.atMm / mmPerUnit;
            path.origin += path.direction * t;
            path.travelled += t;
            path.onTop = false;
            path.bent = true;
            return Leg::Met;
        }
        case TileMarch::Segment::Passed:
            break;
        }
    }
    return Leg::Bounded;
}

ShellExit ReliefMarch::follow(Path path, const ReliefObstacle& obstacle, Rgb& core) {
    const ShellObject& o = object_;
    ShellExit exit;
    for (;;) {
        Ray ray;
        ray.origin = path.origin;
        ray.direction = path.direction;
        ray.tNear = path.onTop ? 1e-3f * o.grid->voxelSize() : 0.0f;
        RayHit hit;
        const bool bounded = o.rayMesh->intersect(ray, hit, 3), top = bounded && hit.geometry == 0;
        const auto leave = [&](const Vec3f& point, const Vec3f& outward) {
            exit = {tile_.transmittance(), point, outward, path.direction, path.travelled, false};
        };
        if (top && !(dot(path.direction, hit.geometricNormal) > 0)) {
            // A surface that is met from outside: rounding has put the path out of the shell already.
            leave(path.origin, path.place.at.normal);
            return exit;
        }
        // An open surface has no other side.
        const float tBound = bounded ? hit.t : 4 * o.thicknessMm / o.mmPerUnit;
        const float tEnd = obstacle ? std::min(tBound, obstacle(path.origin, path.direction)) : tBound;
        ReliefMeeting met;
        const Leg leg = walkStraight(path, tEnd, met);
        if (leg == Leg::Ended) {
            return exit;
        }
        if (leg == Leg::Met) {
            if (!meet(path, path.place.normalOf(met.normal, o.mmPerUnit), path.place.normalOf(met.facet, o.mmPerUnit),
                      met.ior)) {
                return exit;
            }
            continue;
        }
        path.travelled += tEnd;
        path.origin += path.direction * tEnd;
        if (tEnd < tBound) {
            leave(path.origin, path.place.at.normal);
            exit.stopped = true;
            return exit;
        }
        if (!bounded) {
            leave(path.origin, path.direction);
            return exit;
        }
        if (!top) {
            // Where the shell is thinner than its relief is deep the core lies bare: it has an interface of its own.
            // The tile's own bottom has none.
            const Vec3f at = path.place.tilePosition(path.origin, perMm_, o.mmPerUnit);
            if (!path.inside && path.place.known && at.z < float(o.medium->size().z - 1)) {
                // The limit surface's normal: facets of an inner boundary that is squeezed together glitter.
                const Vec3f& limit = path.place.at.normal;
                const Vec3f facet = normalize(hit.geometricNormal);
                const Vec3f normal = dot(limit, path.direction) < 0   ? limit
                                     : dot(facet, path.direction) < 0 ? facet
                                                                      : -facet;
                path.onTop = path.onCore = true;
                if (!meet(path, normal, normal, tile_.iorBelow(at))) {
                    return exit;
                }
                if (!path.inside) {
                    continue;
                }
            }
            if (path.place.known && !o.coreBlack) {
                core += tile_.transmittance() * path.place.at.coreRadiance;
            }
            return exit;
        }
        const Vec3i& corners = o.surface->triangles[hit.triangle];
        path.origin = betweenCorners(o.surface->points, corners, hit.u, hit.v);
        const Vec3f facet = normalize(hit.geometricNormal);
        if (path.inside) {
            Vec3f at = path.place.tilePosition(path.origin, perMm_, o.mmPerUnit);
            at.z = 0;
            path.onTop = true;
            if (!meet(path, normalize(smoothNormal(*o.surface, hit)), facet, tile_.iorAt(at))) {
                return exit;
            }
            if (path.inside) {
                probe_.enter(hit.triangle);
                continue;
            }
        }
        leave(path.origin, facet);
        return exit;
    }
}

bool ReliefMarch::firstSight(const ReliefEntry& entry, ReliefSight& out) {
    const float mmPerUnit = object_.mmPerUnit, middle = 0.5f * step_;
    Path path;
    path.origin = entry.point;
    path.direction = entry.direction;
    probe_.enter(entry.triangle);
    if (path.place.find(probe_, entry.point + entry.direction * middle, core_, level_)) {
        path.place.known = path.bent = true;
        path.place.enterHere(entry.direction, middle, step_, mmPerUnit);
        Vec3f top = path.place.tilePosition(entry.point, perMm_, mmPerUnit);
        top.z = 0;
        if (tile_.insideRelief(top)) {
            out = {entry.point, entry.normal, path.place, 0, 0};
            return true;
        }
    }
    Ray ray;
    ray.origin = entry.point;
    ray.direction = entry.direction;
    ray.tNear = 1e-3f * object_.grid->voxelSize();
    RayHit hit;
    const bool bounded = object_.rayMesh->intersect(ray, hit, 3);
    const float tEnd = bounded ? hit.t : 4 * object_.thicknessMm / mmPerUnit;
    ReliefMeeting met;
    const Leg leg = walkStraight(path, tEnd, met);
    const bool relief = leg == Leg::Met || path.inside; // or it lies under a sliver that the grid does not hold
    const bool core = !relief && bounded && hit.geometry == 1;
    out.travelled = relief ? path.travelled : tEnd;
    out.point = entry.point + entry.direction * out.travelled;
    out.place = path.place;
    out.normal = entry.normal;
    if (path.place.known) {
        out.normal = leg == Leg::Met ? path.place.normalOf(met.normal, mmPerUnit) : path.place.at.normal;
        out.place.carry(out.point - out.place.point, 1, mmPerUnit);
        out.atMm = out.place.at.depth;
    }
    return relief || core;
}

ReliefRadiance ReliefMarch::march(const ReliefEntry& entry) {
    ReliefRadiance out;
    Path path;
    probe_.enter(entry.triangle);
    bool goesOn = true;
    if (entry.within) {
        startWithin(entry, path);
    } else {
        goesOn = start(entry, path);
    }
    if (goesOn) {
        out.through = follow(path, entry.obstacle, out.core);
        const TileRadiance seen = tile_.finish();
        out.single = seen.single;
        out.multiple = seen.multiple;
    }
    if (mirrors_) {
        tile_.branch(mirrorWeight_);
        probe_.enter(entry.triangle);
        Rgb core(0.0f);
        if (mirror_.onTop && !mirror_.onCore) {
            // The limit surface itself mirrors: outside of the shell.
            out.mirror = {mirrorWeight_, mirror_.origin, normalize(entry.facet), mirror_.direction, 0, false};
        } else {
            out.mirror = follow(mirror_, entry.obstacle, core);
            const TileRadiance seen = tile_.finish();
            out.reflection = seen.single + seen.multiple + core;
        }
    }
    return out;
}

} // namespace stf
