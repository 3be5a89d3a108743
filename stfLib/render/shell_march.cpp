// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_march.h"

#include "stfLib/optics/phase.h"
#include "stfLib/optics/step_weights.h"
#include "stfLib/transport/tile_tracer.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr int kMaxLights = 16;
/// Below this the rest of a ray is decided by roulette.
constexpr float kRouletteBelow = 0.01f;

// A step that single scattering may be taken from.
struct Candidate {
    Rgb transmittance;                 // in front of the step
    Vec3f tilePosition, tileDirection; // voxel units at t0 and per object unit
    ShellLookup at;
    float t0 = 0, length = 0; // object units, mm
    int voxel = -1;
    float weight = 0;
};

} // namespace

Vec3f toTileFrame(const ShellLookup& at, const Vec3f& d) {
    const Vec3f& n = at.normal;
    const Vec3f t = normalize(at.gradX - n * dot(at.gradX, n));
    Vec3f b = cross(n, t);
    if (dot(b, at.gradY) < 0) {
        b = -b;
    }
    return {dot(d, t), dot(d, b), dot(d, n)};
}

ShellRadiance ShellMarch::march(const Vec3f& entry, const Vec3f& direction, const ShellLight* lights, int lightCount,
                                PixelSampler& sampler) {
    const ShellObject& o = object_;
    const Vec3i size = o.volume->size, tableSize = o.table->size;
    const Vec3f perMm{float(1 / o.volume->voxelMm.x), float(1 / o.volume->voxelMm.y), float(1 / o.volume->voxelMm.z)};
    const float step = o.grid.voxelSize();
    const TileTracer tracer(size);
    lightCount = std::min(lightCount, kMaxLights);

    // The whole path sees the tile shifted by less than a voxel: the image is that of the exact voxels under a box
    // filter of one voxel, so no single voxel shows its faces. The table is read with a second offset, which makes its
    // expectation the trilinear interpolation.
    const Vec2f shift = sampler.next2d(), offset = sampler.next2d(), third = sampler.next2d();
    const Vec2f tileShift{shift.x - 0.5f, shift.y - 0.5f};
    const Vec3f tableOffset{offset.x - 0.5f, offset.y - 0.5f, third.x - 0.5f};
    Vec2f pick = sampler.next2d();

    ShellRadiance result;
    // Where the shell ends: at the core or back through the surface.
    Ray ray;
    ray.origin = entry;
    ray.direction = direction;
    ray.tNear = 1e-3f * step;
    RayHit end;
    const bool bounded = o.rayMesh->intersect(ray, end, 3);
    const float tEnd = bounded ? end.t : 4 * o.thicknessMm / o.mmPerUnit; // an open surface has no other side
    result.tExit = tEnd;

    // The entry is the tile's top, whatever facets and interpolation make of it: in a dense medium a hundredth of a
    // millimetre would show. The depth at which the first step would start is taken off all of them.
    float entryDepth = 0;

    Rgb transmittance(1.0f), multiple(0.0f);
    Candidate chosen;
    float weightSum = 0;
    ShellLookup at{};
    bool known = false, ended = false;
    DirectionWeights weights[kMaxLights];

    for (float t0 = 0; t0 < tEnd && !ended; t0 += step) {
        const float t1 = std::min(t0 + step, tEnd), middle = 0.5f * (t0 + t1);
        const Vec3f point = entry + direction * middle;
        ShellLookup found;
        if (accessor_.lookup(point, found, core_)) {
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
        for (int l = 0; l < lightCount; ++l) {
            weights[l] = o.table->directions.weights(toTileFrame(at, lights[l].towards));
        }
        const Vec3f tileDirection{dot(at.gradX, direction) * perMm.x, dot(at.gradY, direction) * perMm.y,
                                  -dot(at.normal, direction) * o.mmPerUnit * perMm.z};
        Vec3f tilePosition{at.exemplar.x * perMm.x + tileShift.x, at.exemplar.y * perMm.y + tileShift.y,
                           at.depth * perMm.z};
        tilePosition -= tileDirection * (middle - t0);
        // Facets and interpolation may start a ray a hair outside of the tile.
        tilePosition.z = std::clamp(tilePosition.z, 0.0f, float(size.z));

        tracer.traverse(tilePosition, tileDirection, t1 - t0, [&](int voxel, int, int, int, float a, float b) {
            const VoxelMedium& m = o.voxels[std::size_t(voxel)];
            if (!(maxComponent(m.extinction) > 0)) {
                return true;
            }
            const float length = (b - a) * o.mmPerUnit;
            const StepWeightsRgb w = stepWeights(m.extinction * length);
            const Rgb scattered = transmittance * m.scattering * w.phi1 * length;

            // The table's voxel for the middle of the step.
            const Vec3f p = tilePosition + tileDirection * (0.5f * (a + b)) + tableOffset;
            const int ix = TileTracer::wrap(int(std::floor(p.x)), tableSize.x);
            const int iy = TileTracer::wrap(int(std::floor(p.y)), tableSize.y);
            const int iz = std::clamp(int(std::floor(p.z)), 0, tableSize.z - 1);
            const std::size_t tableVoxel =
                std::size_t(ix) +
                std::size_t(tableSize.x) * (std::size_t(iy) + std::size_t(tableSize.y) * std::size_t(iz));
            Rgb fluence = at.coreRadiance * o.table->backlight[tableVoxel];
            for (int l = 0; l < lightCount; ++l) {
                if (weights[l].count) {
                    fluence += lights[l].forMultiple * o.table->multipleAt(tableVoxel, weights[l]);
                }
            }
            multiple += scattered * fluence * (1 / (4 * kPi));

            // Weighted reservoir of one (Chao 1982): after the loop each step was chosen with probability weight / sum.
            const float weight = average(scattered);
            weightSum += weight;
            if (weight > 0 && pick.x * weightSum < weight) {
                pick.x = pick.x * weightSum / weight; // uniform again
                chosen = {transmittance, tilePosition + tileDirection * a, tileDirection, at, t0 + a, length, voxel,
                          weight};
            } else if (weightSum > 0) {
                pick.x = (pick.x * weightSum - weight) / std::max(weightSum - weight, 1e-30f);
            }
            pick.x = std::clamp(pick.x, 0.0f, 0.99999994f);

            transmittance *= w.transmittance;
            if (maxComponent(transmittance) < kRouletteBelow) {
                // Unbiased: survivors carry the weight of those that end here.
                if (pick.y < 0.25f) {
                    pick.y *= 4;
                    transmittance *= 4.0f;
                } else {
                    pick.y = (pick.y - 0.25f) / 0.75f; // uniform again
                    transmittance = Rgb(0.0f);
                    ended = true;
                    return false;
                }
            }
            return true;
        });
    }
    result.multiple = multiple;

    if (chosen.voxel >= 0) {
        // A point of the step by the free flight of one channel, weighted by the mean density of all three, so that no
        // weight exceeds three whatever the channels' extinctions are (one-sample balance heuristic; Wilkie et al.
        // 2014, "Hero Wavelength Spectral Sampling"). Single scattering has the true phase function and the light's own
        // attenuation through the tile.
        const VoxelMedium& m = o.voxels[std::size_t(chosen.voxel)];
        const float h = chosen.length;
        const auto density = [&](float k, float x) {
            return k * h > 1e-4f ? k * std::exp(-k * x) / -std::expm1(-k * h) : 1 / h;
        };
        const float kappa = m.extinction[std::min(2, int(pick.y * 3))], u = third.y;
        const float s = kappa * h > 1e-4f ? std::min(h, -std::log1p(u * std::expm1(-kappa * h)) / kappa) : u * h;
        const float mean = (density(m.extinction.x, s) + density(m.extinction.y, s) + density(m.extinction.z, s)) / 3;
        const Rgb path = chosen.transmittance * exp(-m.extinction * s) * m.scattering *
                         (weightSum / chosen.weight / std::max(mean, 1e-30f));
        const float along = s / o.mmPerUnit;
        const Vec3f p = chosen.tilePosition + chosen.tileDirection * along;
        for (int l = 0; l < lightCount; ++l) {
            const Vec3f towards = toTileFrame(chosen.at, lights[l].towards);
            if (!(towards.z > 0) || !(maxComponent(lights[l].forSingle) > 0)) {
                continue;
            }
            const Rgb arriving = lights[l].forSingle * exp(-o.medium->opticalDepth(p, towards));
            result.single += path * arriving * henyeyGreenstein(m.g, -lights[l].towards, -direction);
        }
    }

    if (!ended && bounded && end.geometry == 1) {
        result.reachedCore = true;
        if (known && !o.coreBlack) {
            result.core = transmittance * at.coreRadiance;
        }
        transmittance = Rgb(0.0f);
    }
    result.transmittance = transmittance;
    return result;
}

} // namespace stf
