// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_march.h"

#include "stfLib/transport/tile_tracer.h"

namespace stf {

namespace {
constexpr int kMaxLights = 16;
}

TileFrame::TileFrame(const ShellLookup& at) : normal_(at.normal) {
    tangent_ = normalize(at.gradX - normal_ * dot(at.gradX, normal_));
    bitangent_ = cross(normal_, tangent_);
    if (dot(bitangent_, at.gradY) < 0) {
        bitangent_ = -bitangent_;
    }
}

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
    const TileMedium& medium = *object_.medium;
    Vec3f p = topOfTile(object_, at.exemplar);
    if (medium.hasSurface()) { // what lies above a relief has no index of its own
        const Vec3i& size = medium.size();
        const std::size_t column = std::size_t(TileTracer::wrap(int(std::floor(p.x)), size.x)) +
                                   std::size_t(size.x) * std::size_t(TileTracer::wrap(int(std::floor(p.y)), size.y));
        const std::size_t layer = std::size_t(size.x) * std::size_t(size.y);
        int z = 0;
        while (z + 1 < size.z && !(medium.fill(column + layer * std::size_t(z)) > 0)) {
            ++z;
        }
        p.z = float(z) + 0.5f;
    }
    return medium.ior(p);
}

ShellRadiance ShellMarch::march(const Vec3f& entry, std::uint32_t triangle, const Vec3f& direction, float footprintMm,
                                const ShellLight* lights, int lightCount, PixelSampler& sampler) {
    const ShellObject& o = object_;
    // Nothing is drawn where there is nothing to choose.
    const bool choose = tiles_.size() > 1 && footprintMm > 0;
    const int tileLevel = choose ? o.pyramid->levelFor(footprintMm, sampler.next1d()) : 0;
    TileMarch& tile = tiles_[std::size_t(tileLevel)];
    const Vec3d& voxelMm = o.pyramid->levels()[std::size_t(tileLevel)].medium->voxelMm();
    const Vec3f perMm{float(1 / voxelMm.x), float(1 / voxelMm.y), float(1 / voxelMm.z)};
    const int level = o.grid->levelFor(footprintMm);
    const float step = o.grid->voxelSize(level);
    lightCount = std::min(lightCount, kMaxLights);
    MarchLight tileLights[kMaxLights];
    for (int l = 0; l < lightCount; ++l) {
        tileLights[l].forSingle = lights[l].forSingle;
        tileLights[l].forMultiple = lights[l].forMultiple;
    }
    tile.begin(sampler);
    probe_.enter(triangle);

    ShellRadiance result;
    // Where the shell ends: at the core or back through the surface.
    Ray ray;
    ray.origin = entry;
    ray.direction = direction;
    ray.tNear = 1e-3f * o.grid->voxelSize();
    const bool bounded = o.rayMesh->intersect(ray, result.exit, 3);
    const float tEnd = bounded ? result.exit.t : 4 * o.thicknessMm / o.mmPerUnit; // an open surface has no other side
    result.tExit = tEnd;
    result.throughSurface = bounded && result.exit.geometry == 0;

    // The entry is the tile's top, whatever facets and interpolation make of it: in a dense medium a hundredth of a
    // millimetre would show. The depth at which the first step would start is taken off all of them.
    float entryDepth = 0;

    ShellLookup at{};
    bool known = false, goesOn = true;
    for (float t0 = 0; t0 < tEnd && goesOn; t0 += step) {
        const float t1 = std::min(t0 + step, tEnd), middle = 0.5f * (t0 + t1);
        const Vec3f point = entry + direction * middle;
        ShellLookup found;
        if (probe_.lookup(point, found, core_, level)) {
            at = found;
            if (!known && t0 == 0) {
                const float found0 = at.depth + dot(at.normal, direction) * o.mmPerUnit * middle;
                // More than interpolation can be off by: the first lookup lies round a corner, below another face.
                entryDepth = std::abs(found0) < 0.1f * step * o.mmPerUnit ? found0 : 0.0f;
            }
            at.depth -= entryDepth;
            known = true;
        } else if (!known) {
            continue; // a sliver at the rim that the grid does not hold
        } else {
            // Carry the last lookup on: first order is good over about one voxel.
            at.exemplar = at.exemplar + Vec2f(dot(at.gradX, direction), dot(at.gradY, direction)) * step;
            at.depth -= dot(at.normal, direction) * o.mmPerUnit * step;
        }
        if (t1 < tEnd) { // its memory is there when this step is done
            probe_.prefetch(point + direction * step, level);
        }
        const TileFrame frame(at);
        for (int l = 0; l < lightCount; ++l) {
            tileLights[l].towards = frame.toTile(lights[l].towards);
        }
        tile.setFrame(tileLights, lightCount, frame.toTile(-direction));
        // Voxels per millimetre of the way, from gradients in millimetres per object unit.
        const Vec3f tileDirection{dot(at.gradX, direction) * perMm.x / o.mmPerUnit,
                                  dot(at.gradY, direction) * perMm.y / o.mmPerUnit,
                                  -dot(at.normal, direction) * perMm.z};
        const Vec3f tilePosition{at.exemplar.x * perMm.x, at.exemplar.y * perMm.y, at.depth * perMm.z};
        if (o.blend) {
            tile.setBlend(blendAt(at, perMm));
        }
        goesOn = tile.segment(tilePosition - tileDirection * ((middle - t0) * o.mmPerUnit), tileDirection,
                              (t1 - t0) * o.mmPerUnit, at.coreRadiance);
    }
    const TileRadiance collected = tile.finish();
    result.single = collected.single;
    result.multiple = collected.multiple;
    result.transmittance = tile.transmittance();
    if (goesOn && bounded && !result.throughSurface) {
        result.reachedCore = true;
        if (known && !o.coreBlack) {
            result.core = result.transmittance * at.coreRadiance;
        }
        result.transmittance = Rgb(0.0f);
    }
    return result;
}

} // namespace stf
