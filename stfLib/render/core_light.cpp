// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/core_light.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/sampler.h"
#include "stfLib/core/core_solver.h"
#include "stfLib/optics/fresnel.h"
#include "stfLib/render/shell_march.h"
#include "stfLib/transport/lateral_filter.h"
#include "stfLib/transport/tile_tracer.h"

#include <numeric>

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr std::size_t kMinSamples = 400, kMaxSamples = 2200;
constexpr int kDomeSamples = 96, kNearSamples = 8;
constexpr int kMaxLights = 32; ///< of a sample of the core; more are chosen from

// Points spread evenly by area over the inner boundary: strata of equal area along the list of triangles.
struct BoundaryPoints {
    std::vector<std::size_t> triangle;
    std::vector<float> b1, b2;
    double area = 0; // object units
};

BoundaryPoints spread(const ShellObject& o, std::size_t wanted, std::uint64_t seed) {
    const std::vector<Vec3i>& triangles = o.surface->triangles;
    const std::vector<Vec3f>& inner = o.boundary->inner;
    std::vector<double> sum(triangles.size());
    double total = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Vec3d a(inner[std::size_t(triangles[i].x)]), b(inner[std::size_t(triangles[i].y)]),
            c(inner[std::size_t(triangles[i].z)]);
        total += 0.5 * length(cross(b - a, c - a));
        sum[i] = total;
    }
    BoundaryPoints p;
    p.area = total;
    if (!(total > 0)) {
        return p;
    }
    CounterRng rng(seed, 0x636f7265);
    for (std::size_t i = 0; i < wanted; ++i) {
        const double at = (double(i) + double(rng.uniform())) / double(wanted) * total;
        const std::size_t t = std::min<std::size_t>(
            triangles.size() - 1, std::size_t(std::upper_bound(sum.begin(), sum.end(), at) - sum.begin()));
        const float r = std::sqrt(rng.uniform()), v = rng.uniform();
        p.triangle.push_back(t);
        p.b1.push_back(r * (1 - v));
        p.b2.push_back(r * v);
    }
    return p;
}

template<class T>
T blend(const std::vector<T>& values, const Vec3i& t, float b1, float b2) {
    return values[std::size_t(t.x)] * (1 - b1 - b2) + values[std::size_t(t.y)] * b1 + values[std::size_t(t.z)] * b2;
}

// What the shell lets through, sends back and shines downward, by column, blurred to the size of a core sample: one
// column's value holds only the few walks that left there, and the core mixes them anyway.
struct ColumnMaps {
    std::vector<Rgb> reflected;                        ///< [column], below 1 so that the balance converges
    std::vector<Rgb> emitted;                          ///< [column]; empty: none
    std::vector<std::vector<Rgb>> transmitted, direct; ///< [direction][column]

    ColumnMaps(const StfTable& table, double sigmaMm) : reflected(table.reflectedBelow), emitted(table.emittedBelow) {
        const std::size_t columns = std::size_t(table.size.x) * std::size_t(table.size.y);
        const LateralFilter filter(table.size, table.voxelMm, sigmaMm);
        reflected.resize(columns);
        filter.apply(reflected);
        for (Rgb& r : reflected) {
            for (int c = 0; c < 3; ++c) {
                r[c] = std::clamp(r[c], 0.0f, 0.9999f);
            }
        }
        if (!emitted.empty()) {
            emitted.resize(columns);
            filter.apply(emitted);
        }
        const auto slices = [&](const FactoredField& field) {
            std::vector<std::vector<Rgb>> maps(std::size_t(table.directions.count()), std::vector<Rgb>(columns));
            const std::size_t known = std::min(columns, field.items());
            for (int d = 0; d < std::min(table.directions.count(), field.directions); ++d) {
                std::vector<Rgb>& map = maps[std::size_t(d)];
                for (std::size_t i = 0; i < known; ++i) {
                    map[i] = {field.node(i, d, 0), field.node(i, d, 1), field.node(i, d, 2)};
                }
                filter.apply(map);
            }
            return maps;
        };
        transmitted = slices(table.transmitted.get());
        direct = slices(table.direct.get());
    }

    static Rgb blend(const std::vector<std::vector<Rgb>>& maps, std::size_t column, const DirectionWeights& w) {
        Rgb sum(0.0f);
        for (int i = 0; i < w.count; ++i) {
            sum += maps[std::size_t(w.index[i])][column] * w.weight[i];
        }
        return sum;
    }
};

// The frame of the exemplar at a point of a triangle.
ShellLookup frameAt(const ShellObject& o, std::size_t triangle, float b1, float b2) {
    const std::size_t corner = 3 * triangle;
    const Vec3i c{int(corner), int(corner + 1), int(corner + 2)};
    ShellLookup at{};
    at.exemplar = blend(o.map->cornerCoords, c, b1, b2);
    at.gradX = blend(o.map->gradientX, c, b1, b2);
    at.gradY = blend(o.map->gradientY, c, b1, b2);
    at.normal =
        normalize(o.surface->cornerNormals.empty() ? blend(o.surface->normals, o.surface->triangles[triangle], b1, b2)
                                                   : blend(o.surface->cornerNormals, c, b1, b2));
    if (o.pose) {
        o.pose->carry({std::uint32_t(triangle), double(b1), double(b2), 0}, at);
    }
    return at;
}

} // namespace

Vec3f jitterOnSurface(const RayMesh& mesh, const Vec3f& point, const Vec3f& normal, float radius, Vec2f u) {
    Vec3f t, b;
    orthonormalBasis(normal, t, b);
    const float r = radius * std::sqrt(u.x), phi = 2 * kPi * u.y;
    Ray probe;
    probe.origin = point + t * (r * std::cos(phi)) + b * (r * std::sin(phi)) + normal * radius;
    probe.direction = -normal;
    probe.tFar = 2 * radius;
    RayHit hit;
    // Only the front of the same sheet will do.
    return radius > 0 && mesh.intersect(probe, hit, 1) && dot(hit.geometricNormal, normal) > 0
               ? probe.origin + probe.direction * hit.t
               : point;
}

std::vector<Rgb> coreRadiance(const ShellObject& o, const Transform& objectToWorld, const RayScene& scene,
                              const LightSet& lights, float rounding, std::uint64_t seed, Progress& progress) {
    const std::size_t points = o.surface->points.size();
    // Samples about half a diffusion length apart, as far as a direct sum allows.
    double diffusionLength = 1e30;
    const Dipole dipoles[3] = {{o.core.sigmaA.x, o.core.sigmaSPrime.x},
                               {o.core.sigmaA.y, o.core.sigmaSPrime.y},
                               {o.core.sigmaA.z, o.core.sigmaSPrime.z}};
    for (const Dipole& d : dipoles) {
        if (d.diffuseAlbedo() > 0) {
            diffusionLength = std::min(diffusionLength, d.diffusionLength());
        }
    }
    const double areaMm2 = spread(o, 0, seed).area * double(o.mmPerUnit) * double(o.mmPerUnit);
    const double wanted = areaMm2 / (0.25 * diffusionLength * diffusionLength);
    const std::size_t count = std::size_t(std::clamp(wanted, double(kMinSamples), double(kMaxSamples)));
    const BoundaryPoints at = spread(o, count, seed);
    if (at.triangle.empty()) {
        return std::vector<Rgb>(points, Rgb(0.0f));
    }

    const ColumnMaps maps(*o.table, 0.5 * std::sqrt(areaMm2 / double(count)));
    CoreSamples s;
    s.positions.resize(count);
    s.areas.assign(count, float(areaMm2 / double(count)));
    s.diffuse.assign(count, Rgb(0.0f));
    s.direct = s.shellReflectance = s.diffuse;
    const Transform worldToObject = objectToWorld.inverse();
    const Vec3i size = o.table->size;
    const float offset = 1e-3f * o.grid->voxelSize();

    parallelFor(count, 16, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3i& tri = o.surface->triangles[at.triangle[i]];
            const ShellLookup frame = frameAt(o, at.triangle[i], at.b1[i], at.b2[i]);
            s.positions[i] = blend(o.boundary->inner, tri, at.b1[i], at.b2[i]) * o.mmPerUnit;
            const Vec3f outer = blend(o.surface->points, tri, at.b1[i], at.b2[i]);
            const int ix = TileTracer::wrap(int(std::floor(frame.exemplar.x / float(o.volume->voxelMm.x))), size.x);
            const int iy = TileTracer::wrap(int(std::floor(frame.exemplar.y / float(o.volume->voxelMm.y))), size.y);
            const std::size_t column = std::size_t(ix) + std::size_t(size.x) * std::size_t(iy);
            s.shellReflectance[i] = maps.reflected[column];
            if (!maps.emitted.empty()) {
                s.diffuse[i] += maps.emitted[column];
            }
            const TileFrame tile(frame);
            const float ior = o.medium->ior(topOfTile(o, frame.exemplar));

            const Vec3f worldNormal = normalize(Vec3f(objectToWorld.normal(Vec3d(frame.normal))));
            const Vec3f worldPoint(objectToWorld.point(Vec3d(outer)));
            LightPick picks[kMaxLights];
            PixelSampler chooser(seed, i, 0);
            const int chosen = lights.choose(worldPoint, worldNormal, chooser.next1d(), kMaxLights, picks);
            for (int p = 0; p < chosen; ++p) {
                const std::size_t l = picks[p].light;
                const int n = lights.isDome(l) ? kDomeSamples : kNearSamples;
                for (int k = 0; k < n; ++k) {
                    PixelSampler sampler(seed + 17 * l, i, std::uint32_t(k));
                    const Vec2f u = sampler.next2d(), v = sampler.next2d();
                    const LightSample light = lights.sample(l, worldPoint, worldNormal, u);
                    const Vec3f towards = normalize(Vec3f(worldToObject.vector(Vec3d(light.towards))));
                    const Vec3f local = tile.toTile(towards);
                    if (!(local.z > 0) || !(maxComponent(light.irradiance) > 0)) {
                        continue;
                    }
                    const Vec3f start =
                        jitterOnSurface(*o.rayMesh, outer, frame.normal, o.blurRadiusMm / o.mmPerUnit, v);
                    const Vec3f from =
                        Vec3f(objectToWorld.point(Vec3d(start + frame.normal * offset))) + worldNormal * rounding;
                    if (light.shadows && scene.occluded(shadowRay(from, light))) {
                        continue;
                    }
                    const DirectionWeights w = o.table->directions.weights(local);
                    const Rgb all = ColumnMaps::blend(maps.transmitted, column, w);
                    const Rgb direct = ColumnMaps::blend(maps.direct, column, w);
                    const Rgb in = light.irradiance * (picks[p].weight / float(n));
                    // The core has the index of the shell: what has not collided arrives at the refracted angle. Its
                    // share is that of the table's own, scaled medium (DESIGN 3.10).
                    const double cosine = double(fresnel(local.z, ior).cosT);
                    s.diffuse[i] += in * (all - direct);
                    for (int c = 0; c < 3; ++c) {
                        const double diffuse = dipoles[c].diffuseAlbedo();
                        if (diffuse > 0) {
                            const double ratio = dipoles[c].directAlbedo(cosine) / diffuse;
                            s.direct[i][c] += in[c] * direct[c] * float(ratio);
                        }
                    }
                }
            }
        }
    });

    CoreSolver solver(o.core, std::move(s));
    solver.solve(progress);
    std::vector<Rgb> radiance(points);
    parallelFor(points, 64, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        for (std::size_t i = begin; i < end; ++i) {
            radiance[i] = solver.exitance(o.boundary->inner[i] * o.mmPerUnit) / kPi;
        }
    });
    return radiance;
}

} // namespace stf
