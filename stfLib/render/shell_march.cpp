// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_march.h"

#include "stfLib/transport/tile_tracer.h"

namespace stf {

Vec3f topOfTile(const ShellObject& object, const Vec2f& mm) {
    const Vec3d& voxel = object.medium->voxelMm();
    return {float(double(mm.x) / voxel.x), float(double(mm.y) / voxel.y), 0};
}

BlendPlace ShellMarch::blendAt(const ShellLookup& at, const Vec3f& perMm) const {
    const TriangleBlend& t = object_.blend->triangles[at.triangle];
    const Vec2d& tile = object_.blend->first.tileMm;
    const PlacesAt here = placesAt(t, at.exemplar, {float(tile.x), float(tile.y)});
    BlendPlace out;
    out.weight = here.weight;
    for (std::size_t i = 0; i < 2; ++i) {
        out.alongX[i] = {t.across[i][0].x, t.across[i][0].y * (perMm.y / perMm.x)};
        out.alongY[i] = {t.across[i][1].x * (perMm.x / perMm.y), t.across[i][1].y};
        out.origin[i] = Vec2f(here.other[i].x * perMm.x, here.other[i].y * perMm.y) -
                        out.alongX[i] * (at.exemplar.x * perMm.x) - out.alongY[i] * (at.exemplar.y * perMm.y);
    }
    return out;
}

ShellMarch::ShellMarch(const ShellObject& object, const Rgb* coreRadiancePerSample)
    : object_(object), probe_(*object.grid, *object.surface, object.pose.get()), core_(coreRadiancePerSample) {
    const std::vector<TilePyramid::Level>& levels = object.pyramid->levels();
    tiles_.reserve(levels.size());
    for (std::size_t l = 0; l < levels.size(); ++l) {
        tiles_.emplace_back(*levels[l].medium, *levels[l].table, object.blend ? object.mixers[l].get() : nullptr);
    }
}

float ShellMarch::iorAt(const Vec3f& point, std::uint32_t triangle) {
    ShellLookup at;
    probe_.enter(triangle);
    if (!probe_.lookup(point, at)) {
        return 1;
    }
    return object_.medium->ior(topOfTile(object_, at.exemplar));
}

bool ShellMarch::firstSight(const ReliefEntry& entry, ReliefSight& out) {
    PixelSampler sampler(0, 0, 0); // nothing depends on it
    tiles_.front().begin(sampler, {0, 0});
    return ReliefMarch(object_, probe_, tiles_.front(), nullptr, 0, nullptr, 0, sampler).firstSight(entry, out);
}

Rgb ShellMarch::albedoAt(const ShellLookup& at, float fromMm) const {
    const BaseVolume& v = *object_.volume;
    const auto column = [&](float x, float y) {
        return Vec2f(float(TileTracer::wrap(int(std::floor(x)), v.size.x)),
                     float(TileTracer::wrap(int(std::floor(y)), v.size.y)));
    };
    const Vec3f top = topOfTile(object_, at.exemplar);
    const Vec2f own = column(top.x, top.y);
    const int first = std::clamp(int(std::floor(fromMm / float(v.voxelMm.z))), 0, v.size.z - 1);
    if (object_.blend && !object_.mixers.empty() && object_.mixers.front()) {
        const Vec3d& mm = v.voxelMm;
        const BlendPlace place = blendAt(at, {float(1 / mm.x), float(1 / mm.y), float(1 / mm.z)});
        std::array<std::size_t, 3> columns{};
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec2f p =
                i == 0 ? own
                       : column(place.origin[i - 1].x + place.alongX[i - 1].x * top.x + place.alongY[i - 1].x * top.y,
                                place.origin[i - 1].y + place.alongX[i - 1].y * top.x + place.alongY[i - 1].y * top.y);
            columns[i] = std::size_t(p.x) + std::size_t(v.size.x) * std::size_t(p.y);
        }
        const TileMedium::Voxel m = object_.mixers.front()->voxel(columns, place, first);
        Rgb albedo(0.0f);
        for (int c = 0; c < 3; ++c) {
            // Extinction is that of the scaled medium: less what is scattered straight on.
            const float extinction = m.extinction[c] + m.scattering[c] * (1 - m.keep);
            albedo[c] = extinction > 0 ? m.scattering[c] / extinction : 0.0f;
        }
        return albedo;
    }
    for (int z = first; z < v.size.z; ++z) {
        const std::size_t i = v.index(int(own.x), int(own.y), z);
        if (maxComponent(v.extinction[i]) > 0) {
            return v.albedo[i];
        }
    }
    return Rgb(0.0f);
}

bool ShellMarch::holds(const Vec3f& point, const Vec3f& direction, ShellLookup& at) {
    Ray ray;
    ray.origin = point;
    ray.direction = direction;
    RayHit hit;
    if (!object_.rayMesh->intersect(ray, hit, 3)) {
        return false;
    }
    // From between the two a ray leaves through the surface or goes into the core.
    const float out = dot(direction, hit.geometricNormal);
    if (hit.geometry == 0 ? !(out > 0) : !(out < 0)) {
        return false;
    }
    probe_.enter(hit.triangle);
    const float slack = 0.5f * object_.grid->voxelSize() * object_.mmPerUnit;
    return probe_.lookup(point, at) && at.depth > -slack && at.depth < object_.thicknessMm + slack;
}

bool ShellMarch::coreHolds(const Vec3f& point, const Vec3f& direction, Rgb& radiance) {
    Ray ray;
    ray.origin = point;
    ray.direction = direction;
    RayHit hit;
    if (object_.grid->report().rimEdges > 0 || !object_.rayMesh->intersect(ray, hit, 3) || hit.geometry != 1 ||
        !(dot(direction, hit.geometricNormal) > 0)) {
        return false;
    }
    ShellLookup at;
    probe_.enter(hit.triangle);
    radiance = Rgb(0.0f);
    if (probe_.lookup(point + direction * hit.t, at, core_)) {
        Vec3f below = topOfTile(object_, at.exemplar);
        below.z = float(object_.medium->size().z) - 0.5f;
        const float ior = object_.medium->refracts() ? object_.medium->ior(below) : 1.0f; // which the core has too
        radiance = at.coreRadiance / (ior * ior);
    }
    return true;
}

float ShellMarch::iorWithin(const Vec3f& point, const ShellLookup& at) const {
    const TileMedium& medium = *object_.medium;
    if (!medium.refracts()) {
        return 1;
    }
    if (!medium.hasSurface()) {
        return medium.ior(topOfTile(object_, at.exemplar));
    }
    ShellPlace place;
    place.at = at;
    place.point = point;
    const Vec3d& mm = medium.voxelMm();
    Vec3f p = place.tilePosition(point, {float(1 / mm.x), float(1 / mm.y), float(1 / mm.z)}, object_.mmPerUnit);
    p.z = std::clamp(p.z, 0.0f, float(medium.size().z));
    return medium.surface().inside(p) ? medium.ior(p) : 1.0f;
}

ReliefRadiance ShellMarch::marchRelief(const ReliefEntry& entry, float footprintMm, const ShellLight* lights,
                                       int lightCount, PixelSampler& sampler) {
    TileMarch& tile = tiles_.front(); // a relief has no coarser levels
    tile.begin(sampler, TileMarch::shiftFor(footprintMm, object_.medium->voxelMm()));
    return ReliefMarch(object_, probe_, tile, core_, object_.grid->levelFor(object_.levelFootprint(footprintMm)),
                       lights, lightCount, sampler)
        .march(entry);
}

ShellRadiance ShellMarch::march(const Vec3f& entry, std::uint32_t triangle, const Vec3f& direction, float footprintMm,
                                const ShellLight* lights, int lightCount, PixelSampler& sampler,
                                const ShellSpan& span) {
    const ShellObject& o = object_;
    const float levelFootprint = o.levelFootprint(footprintMm);
    // Nothing is drawn where there is nothing to choose.
    const bool choose = tiles_.size() > 1 && footprintMm > 0;
    const int tileLevel = choose ? o.pyramid->levelFor(levelFootprint, sampler.next1d()) : 0;
    TileMarch& tile = tiles_[std::size_t(tileLevel)];
    const Vec3d& voxelMm = o.pyramid->levels()[std::size_t(tileLevel)].medium->voxelMm();
    const Vec3f perMm{float(1 / voxelMm.x), float(1 / voxelMm.y), float(1 / voxelMm.z)};
    const int level = o.grid->levelFor(levelFootprint);
    const float step = o.marchStep(level);
    TileLights tileLights(lights, lightCount);
    tile.begin(sampler, TileMarch::shiftFor(footprintMm, voxelMm));
    probe_.enter(triangle);

    ShellRadiance result;
    // Where the shell ends: at the core or back through the surface.
    Ray ray;
    ray.origin = entry;
    ray.direction = direction;
    ray.tNear = span.fromWithin ? 0.0f : 1e-3f * o.grid->voxelSize();
    const bool bounded = o.rayMesh->intersect(ray, result.exit, 3);
    const float tBound = bounded ? result.exit.t : 4 * o.thicknessMm / o.mmPerUnit; // an open surface has no other side
    const float tEnd = std::min(tBound, span.stop);
    result.tExit = tEnd;
    result.stopped = span.stop < tBound;
    result.throughSurface = bounded && result.exit.geometry == 0 && !result.stopped;

    ShellPlace place;
    bool goesOn = true;
    for (float t0 = 0; t0 < tEnd && goesOn; t0 += step) {
        const float t1 = std::min(t0 + step, tEnd), middle = 0.5f * (t0 + t1);
        const Vec3f point = entry + direction * middle;
        if (place.find(probe_, point, core_, level)) {
            if (!place.known && t0 == 0 && !span.fromWithin) {
                place.enterHere(direction, middle, step, o.mmPerUnit);
            }
            place.known = true;
        } else if (!place.known) {
            continue; // a sliver at the rim that the grid does not hold
        } else {
            place.carry(direction, step, o.mmPerUnit);
        }
        if (t1 < tEnd) { // its memory is there when this step is done
            probe_.prefetch(point + direction * step, level);
        }
        tileLights.setFrame(place.at, direction, tile);
        const TileLine line = place.lineAlong(direction, middle - t0, perMm, o.mmPerUnit);
        if (o.blend) {
            tile.setBlend(blendAt(place.at, perMm));
        }
        goesOn = tile.segment(line.position, line.voxelsPerMm, (t1 - t0) * o.mmPerUnit, place.at.coreRadiance);
    }
    const TileRadiance collected = tile.finish();
    result.single = collected.single;
    result.multiple = collected.multiple;
    result.transmittance = tile.transmittance();
    if (goesOn && bounded && !result.throughSurface && !result.stopped) {
        result.reachedCore = true;
        if (place.known && !o.coreBlack) {
            result.core = result.transmittance * place.at.coreRadiance;
        }
        result.transmittance = Rgb(0.0f);
    }
    return result;
}

} // namespace stf
