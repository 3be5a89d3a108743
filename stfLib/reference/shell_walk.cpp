// SPDX-License-Identifier: Apache-2.0
#include "stfLib/reference/shell_walk.h"

#include "stfLib/optics/phase.h"
#include "stfLib/render/surface_crossing.h"
#include "stfLib/render/surface_point.h"

#include <limits>

namespace stf {

namespace {

constexpr float kEndless = 1e30f;
/// Box diagonals beyond an open object at which what wanders in its endless core is given up.
constexpr float kLost = 2;
/// Of a voxel: how near the root of a relief is found, and how far a path may be on its wrong side by rounding.
constexpr float kRoot = 1e-4f, kWrongSide = 0.02f, kLeastStep = 0.05f;
/// Light on a straight way of which less is left goes on with the chance that makes up for it.
constexpr float kFaint = 0.1f;
/// A path that rounding lets slip through a surface must not go on scattering where nothing ends it: no medium is
/// further outside of the tile than this share of its depth, and flights that end nearer to a boundary than positions
/// are exact (relative to the object's extent, and to the flight) cross it.
constexpr float kOutside = 0.05f, kPosition = 5e-7f, kFlight = 1e-6f;

float sum(const Rgb& c) {
    return c.x + c.y + c.z;
}

// True with a chance of what is left over kFaint; then it counts for the more.
bool survives(Rgb& left, CounterRng& rng) {
    const float most = maxComponent(left);
    if (most >= kFaint) {
        return true;
    }
    if (!(rng.uniform() * kFaint < most)) {
        left = Rgb(0.0f);
        return false;
    }
    left *= kFaint / most;
    return true;
}

} // namespace

ShellWalk::ShellWalk(const ShellObject& object, std::shared_ptr<const ReferenceMedium> medium)
    : object_(object), medium_(std::move(medium)),
      walkSpace_(*object.grid, *object.surface, object.pose.get(), object.mmPerUnit),
      straightSpace_(*object.grid, *object.surface, object.pose.get(), object.mmPerUnit),
      majorant_(medium_->majorant() * object.mmPerUnit), lift_(1e-3f * object.grid->voxelSize()),
      rim_(4 * object.thicknessMm / object.mmPerUnit), reach_(kLost * object.surface->bounds.diagonal()),
      middle_((object.surface->bounds.lo + object.surface->bounds.hi) * 0.5f),
      rounding_(kPosition * (length(middle_) + 0.5f * object.surface->bounds.diagonal())),
      refractingRelief_(medium_->refracts() && medium_->hasRelief()) {
    if (!object.coreBlack) {
        const double perUnit = double(object.mmPerUnit);
        coreScattering_ = Rgb(object.core.sigmaSPrime * perUnit);
        coreExtinction_ = Rgb((object.core.sigmaA + object.core.sigmaSPrime) * perUnit);
        coreMajorant_ = maxComponent(coreExtinction_);
    }
}

// What bounds the way straight on. False: nothing; tEnd is then where an open shell's rim is taken to be.
bool ShellWalk::nearest(const State& s, RayHit& hit, float& tEnd) {
    Ray ray;
    ray.origin = s.origin;
    ray.direction = s.direction;
    ray.tNear = s.onSurface ? lift_ : 0.0f;
    const bool core = s.region == Region::Core;
    ++rays_;
    const bool bounded = object_.rayMesh->intersect(ray, hit, core ? 2 : 3);
    tEnd = bounded ? hit.t : core ? kEndless : rim_;
    return bounded;
}

// Whether rounding has put a path of the core, of which nothing is in front of it, into the shell.
bool ShellWalk::belongsToShell(const State& s) {
    Ray ray;
    ray.origin = s.origin;
    ray.direction = s.direction;
    RayHit hit;
    return object_.rayMesh->intersect(ray, hit, 1) && dot(s.direction, hit.geometricNormal) > 0;
}

// Fresnel's equations by chance at an interface with its normals out of the material. True: refracted.
bool ShellWalk::interface(State& s, const Vec3f& normal, const Vec3f& facet, float ior, CounterRng& rng) {
    const bool within = s.region != Region::Void;
    const float side = within ? -1.0f : 1.0f;
    if (ior == 1 || !(dot(s.direction, facet) * side < 0)) {
        return true; // carried across between two places of the sample: nothing faces it
    }
    ++s.interfaces;
    const SurfaceCrossing c = crossSurface(s.direction, normal * side, facet * side, within ? 1 / ior : ior);
    const bool reflects = rng.uniform() < c.reflectance;
    s.direction = reflects ? c.reflected : c.refracted;
    s.interfaces += reflects ? 1 : 0; // no straight way leads there
    return !reflects;
}

float ShellWalk::transmit(State& s, const Vec3f& normal, const Vec3f& facet, float ior) {
    const bool within = s.region != Region::Void;
    const float side = within ? -1.0f : 1.0f;
    if (ior == 1 || !(dot(s.direction, facet) * side < 0)) {
        return 1;
    }
    const SurfaceCrossing c = crossSurface(s.direction, normal * side, facet * side, within ? 1 / ior : ior);
    s.direction = c.refracted;
    return ++s.interfaces > 1 ? 0.0f : 1 - c.reflectance;
}

// First point in (from, to] where a refracting relief passes the way; infinity: none. `lost`: rounding left the path on
// the wrong side, there is no interface.
float ShellWalk::crossing(const State& s, float from, float to, bool& lost) {
    const bool inside = s.region == Region::Material;
    const float voxel = medium_->leastVoxelMm() / object_.mmPerUnit;
    const auto wrong = [&](float t, float& clear) {
        Vec3f mm;
        if (!space_->locate(s.origin + s.direction * t, mm)) {
            clear = 0.5f * voxel;
            return !inside ? false : true; // nothing is known to be there
        }
        const float d = medium_->distance(mm);
        clear = std::abs(d) / std::max(medium_->steepest() * space_->squeeze(), 1e-20f);
        return inside ? d >= 0 : d < 0;
    };
    lost = false;
    bool agreed = from > 0;
    float last = from, t = from;
    float clear = 0;
    while (true) {
        if (wrong(t, clear)) {
            if (agreed) {
                float lo = last, hi = t;
                for (int i = 0; i < 24 && hi - lo > kRoot * voxel; ++i) {
                    const float middle = 0.5f * (lo + hi);
                    (wrong(middle, clear) ? hi : lo) = middle;
                }
                return hi;
            }
            if (t - from > kWrongSide * voxel) {
                lost = true;
                return t;
            }
        } else {
            agreed = true;
        }
        if (t >= to) {
            return std::numeric_limits<float>::infinity();
        }
        last = t;
        t = std::min(to, t + (agreed ? std::max(clear, kLeastStep * voxel) : 0.51f * kWrongSide * voxel));
    }
}

void ShellWalk::surfaceNormals(const State& s, Vec3f& normal, Vec3f& facet, float& ior) {
    Vec3f mm;
    space_->locate(s.origin, mm);
    facet = space_->normalOf(medium_->gradient(mm));
    normal = space_->normalOf(medium_->smoothGradient(mm));
    ior = medium_->ior(medium_->voxelAt(mm));
}

bool ShellWalk::enter(const Vec3f& point, const Vec3f& direction, const Vec3f& normal, const Vec3f& facet,
                      std::uint32_t triangle, CounterRng& rng, State& s) {
    s = {};
    s.origin = point;
    s.direction = direction;
    s.onSurface = true;
    s.region = Region::Void;
    space_->enter(triangle);
    Vec3f mm;
    const bool known = space_->locate(point, mm);
    mm.z = 0;
    // A sliver at a rim that the grid does not hold has no interface.
    if (!known || (!refractingRelief_ && !medium_->refracts())) {
        s.region = Region::Material;
        return true;
    }
    if (!medium_->inside(mm)) {
        return true;
    }
    const float ior = medium_->ior(medium_->voxelAt(mm));
    if (!interface(s, normal, normalize(facet), ior, rng)) {
        return false;
    }
    s.region = Region::Material;
    iorAbove_ = ior;
    return true;
}

bool ShellWalk::bareCore(const State& s, const Vec3f& mm) const {
    return refractingRelief_ && s.region == Region::Void && space_->known() && medium_->aboveLastLayer(mm.z);
}

ShellWalk::Region ShellWalk::regionAbove(const Vec3f& point, Vec3f& mm) {
    return space_->locate(point, mm) && !medium_->inside(mm) && refractingRelief_ ? Region::Void : Region::Material;
}

// The limit surface's normal: facets of an inner boundary that is squeezed together glitter.
Vec3f ShellWalk::coreNormal(const State& s, const RayHit& hit) const {
    const Vec3f facet = normalize(hit.geometricNormal);
    const bool outward = s.region == Region::Core;
    const float side = outward ? -1.0f : 1.0f;
    const Vec3f& limit = space_->normal();
    return dot(limit, s.direction) * side < 0 ? limit : dot(facet, s.direction) * side < 0 ? facet : -facet;
}

// The path has come to the end of its straight way. `crosses(state, normal, facet, ior)` decides on interfaces: whether
// it is refracted (else it is turned or ended by its caller's flag).
template<class Crosses>
ShellWalk::Event ShellWalk::bound(State& s, bool bounded, const RayHit& hit, float tEnd, Outcome& out,
                                  Crosses&& crosses) {
    const Vec3f end = s.origin + s.direction * tEnd;
    const auto leave = [&](const Vec3f& point, const Vec3f& outward) {
        out = {true, s.interfaces, point, s.direction, outward};
        return Event::Left;
    };
    if (!bounded) {
        return leave(s.origin, s.direction); // by an open rim
    }
    const Vec3f facet = normalize(hit.geometricNormal);
    const bool outwards = dot(s.direction, facet) > 0;
    if (hit.geometry == 0) {
        if (!outwards) {
            return leave(s.origin, s.direction); // met from outside: it left where rounding did not see it
        }
        const Vec3i& corners = object_.surface->triangles[hit.triangle];
        s.origin = betweenCorners(object_.surface->points, corners, hit.u, hit.v);
        s.onSurface = true;
        space_->enter(hit.triangle);
        Vec3f mm;
        const bool known = space_->locate(s.origin, mm);
        mm.z = 0;
        if (s.region == Region::Material && known && medium_->refracts()) {
            const float ior = medium_->ior(medium_->voxelAt(mm));
            if (!crosses(normalize(smoothNormal(*object_.surface, hit)), facet, ior)) {
                return Event::Goes;
            }
        }
        return leave(s.origin, facet);
    }
    if (s.region == Region::Core) {
        s.origin = end;
        s.onSurface = true;
        if (!outwards) {
            return Event::Goes; // another part of the boundary, from its other side: nothing is there
        }
        space_->enter(hit.triangle);
        Vec3f mm;
        const Region above = regionAbove(end, mm);
        if (above == Region::Void && medium_->aboveLastLayer(mm.z)) {
            const Vec3f normal = coreNormal(s, hit);
            if (!crosses(normal, normal, medium_->iorBelow(mm))) {
                return Event::Goes;
            }
        }
        s.region = above;
        return Event::Goes;
    }
    s.origin = end;
    s.onSurface = true;
    if (outwards) {
        return Event::Goes; // from below, where rounding left it: it is where it belongs now
    }
    Vec3f mm;
    space_->locate(end, mm);
    if (bareCore(s, mm)) {
        const Vec3f normal = coreNormal(s, hit);
        if (!crosses(normal, normal, medium_->iorBelow(mm))) {
            return Event::Goes;
        }
    }
    if (object_.coreBlack) {
        return Event::Absorbed;
    }
    s.region = Region::Core;
    return Event::Goes;
}

// A tentative collision with chances by the channels' mean. False: absorbed.
bool ShellWalk::scatter(State& s, const WalkVertex& vertex, const Rgb& extinction, const Rgb& scattering,
                        float majorant, Rgb& throughput, WalkVisitor& visitor, CounterRng& rng) {
    const float all = sum(throughput) * majorant;
    const Rgb scattered = throughput * scattering, passed = throughput * (Rgb(majorant) - extinction);
    const float chance = sum(scattered) / all, pass = sum(passed) / all, u = rng.uniform();
    if (u < chance) {
        throughput = scattered / (majorant * chance);
        visitor.visit(vertex, throughput);
        s.direction = sampleHenyeyGreenstein(vertex.g, s.direction, rng.uniform(), rng.uniform());
        s.interfaces = 0;
        ++s.scatterings;
        visitor.turned(vertex, s.direction);
        return true;
    }
    if (u < chance + pass) {
        throughput = passed / (majorant * pass);
        return true;
    }
    return false;
}

bool ShellWalk::hasMedium(const Vec3f& point, Vec3f& mm) {
    const float beside = kOutside * object_.thicknessMm;
    return space_->locate(point, mm) && mm.z > -beside && mm.z < object_.thicknessMm + beside && medium_->inside(mm);
}

bool ShellWalk::collide(State& s, Rgb& throughput, WalkVisitor& visitor, CounterRng& rng, Rgb& shone) {
    Vec3f mm;
    if (!hasMedium(s.origin, mm)) {
        return true;
    }
    const std::size_t voxel = medium_->voxelAt(mm);
    if (medium_->emits()) {
        const float n = medium_->ior(voxel);
        shone += throughput * medium_->emission(voxel) / (n * n * medium_->majorant());
    }
    WalkVertex vertex{s.origin, s.direction, space_->normal(), medium_->g(voxel), medium_->ior(voxel), false};
    iorAbove_ = vertex.ior;
    const Rgb& k = medium_->extinction(voxel);
    return scatter(s, vertex, k, k * medium_->albedo(voxel), medium_->majorant(), throughput, visitor, rng);
}

ShellWalk::Outcome ShellWalk::follow(State& s, Rgb& throughput, WalkVisitor& visitor, CounterRng& rng, Rgb& shone) {
    Outcome out;
    for (;;) {
        RayHit hit;
        float tEnd = 0;
        const bool bounded = nearest(s, hit, tEnd);
        if (!bounded && s.region == Region::Core && belongsToShell(s)) {
            s.region = Region::Material;
            continue;
        }
        const Vec3f from = s.origin;
        const float majorant = s.region == Region::Core ? coreMajorant_ : s.region == Region::Void ? 0.0f : majorant_;
        const int scatterings = s.scatterings;
        float t = 0;
        bool turned = false;
        while (!turned) {
            const float flight = majorant > 0 ? rng.exponential() / majorant : kEndless;
            const float next = std::min(t + flight, tEnd);
            bool lost = false;
            if (refractingRelief_ && s.region != Region::Core) {
                const float root = crossing(s, t, next, lost);
                if (root <= next) {
                    s.origin = from + s.direction * root;
                    s.onSurface = false;
                    Vec3f normal, facet;
                    float ior = 1;
                    surfaceNormals(s, normal, facet, ior);
                    if (lost || interface(s, normal, facet, ior, rng)) {
                        s.region = s.region == Region::Void ? Region::Material : Region::Void;
                    }
                    break;
                }
            }
            if (!(t + flight < tEnd * (1 - kFlight) - rounding_)) {
                const Event e = bound(s, bounded, hit, tEnd, out, [&](const Vec3f& n, const Vec3f& f, float ior) {
                    return interface(s, n, f, ior, rng);
                });
                if (e == Event::Left) {
                    return out;
                }
                if (e == Event::Absorbed) {
                    return {};
                }
                break;
            }
            t = next;
            State at = s;
            at.origin = from + s.direction * t;
            at.onSurface = false;
            bool goesOn = true;
            if (s.region == Region::Core) {
                at.metCore = true;
                const WalkVertex vertex{at.origin, at.direction, space_->normal(), 0, 1, true};
                goesOn = scatter(at, vertex, coreExtinction_, coreScattering_, coreMajorant_, throughput, visitor, rng);
            } else {
                goesOn = collide(at, throughput, visitor, rng, shone);
            }
            if (!goesOn) {
                return {};
            }
            turned = at.scatterings != scatterings;
            if (turned) {
                s = at;
                if (!bounded && length(s.origin - middle_) > reach_) {
                    return {};
                }
            }
        }
    }
}

Rgb ShellWalk::wayOut(const State& from, CounterRng& rng, Outcome& out) {
    straightSpace_.enter(walkSpace_.triangle());
    return straightOut(from, rng, out);
}

Rgb ShellWalk::straightOut(State s, CounterRng& rng, Outcome& out) {
    space_ = &straightSpace_;
    const Rgb left = estimateStraight(s, rng, out);
    space_ = &walkSpace_;
    return left;
}

Rgb ShellWalk::estimateStraight(State s, CounterRng& rng, Outcome& out) {
    Rgb left(1.0f);
    for (;;) {
        RayHit hit;
        float tEnd = 0;
        const bool bounded = nearest(s, hit, tEnd);
        if (s.region == Region::Core) {
            left *= exp(-coreExtinction_ * tEnd);
            if (!bounded || !survives(left, rng)) {
                return Rgb(0.0f);
            }
        }
        const Vec3f from = s.origin;
        const float majorant = s.region == Region::Material ? majorant_ : 0.0f;
        float t = 0;
        for (;;) {
            const float flight = majorant > 0 ? rng.exponential() / majorant : kEndless;
            const float next = std::min(t + flight, tEnd);
            bool lost = false;
            const float root = refractingRelief_ && s.region != Region::Core ? crossing(s, t, next, lost)
                                                                             : std::numeric_limits<float>::infinity();
            if (root <= next) {
                s.origin = from + s.direction * root;
                s.onSurface = false;
                Vec3f normal, facet;
                float ior = 1;
                surfaceNormals(s, normal, facet, ior);
                left *= lost ? 1.0f : transmit(s, normal, facet, ior);
                s.region = s.region == Region::Void ? Region::Material : Region::Void;
                break;
            }
            if (!(t + flight < tEnd * (1 - kFlight) - rounding_)) {
                const Event e = bound(s, bounded, hit, tEnd, out, [&](const Vec3f& n, const Vec3f& f, float ior) {
                    left *= transmit(s, n, f, ior);
                    return true;
                });
                if (e == Event::Absorbed) {
                    return Rgb(0.0f);
                }
                if (e == Event::Left) {
                    return left;
                }
                break;
            }
            t = next;
            Vec3f mm;
            if (hasMedium(from + s.direction * t, mm)) {
                left *= Rgb(1.0f) - medium_->extinction(medium_->voxelAt(mm)) / medium_->majorant();
                if (!survives(left, rng)) {
                    return left;
                }
            }
        }
        if (!(maxComponent(left) > 0)) {
            return Rgb(0.0f);
        }
    }
}

Rgb ShellWalk::passThrough(const Vec3f& point, const Vec3f& direction, std::uint32_t triangle, CounterRng& rng,
                           Outcome& out) {
    State s;
    s.origin = point;
    s.direction = direction;
    s.onSurface = true;
    straightSpace_.enter(triangle);
    return straightOut(s, rng, out);
}

} // namespace stf
