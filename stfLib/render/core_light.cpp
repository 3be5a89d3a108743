// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/core_light.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/sampler.h"
#include "stfLib/core/local_thickness.h"
#include "stfLib/optics/fresnel.h"
#include "stfLib/render/plain_shader.h"
#include "stfLib/render/shell_march.h"
#include "stfLib/transport/lateral_filter.h"
#include "stfLib/transport/tile_tracer.h"

#include <algorithm>
#include <cstdio>

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;
constexpr std::size_t kMinSamples = 400;
constexpr std::size_t kMaxSamples = 24'000; ///< more take longer than they show
constexpr double kSpacing = 0.5;                      ///< of the spread length, between samples
constexpr double kFinestSpacing = 0.45;               ///< the same where thin parts ask for more
constexpr std::size_t kProbes = 300;                  ///< of the thickness
constexpr float kFilterSpacings = 1.8f;               ///< radius within which samples make the exitance of a point
constexpr std::uint64_t kBounceSeed = 0x626f756e6365; ///< apart from those of lights
constexpr int kMaxLights = 32;                        ///< of a sample of the core; more are chosen from
/// Rays to a dome, to another light and for bounced light: fewer per sample where samples are many, since the core
/// mixes them anyway.
constexpr std::size_t kDomeRays = 200'000, kNearRays = 80'000, kBounceRays = 65'000;

int raysPerSample(std::size_t all, std::size_t samples, int least, int most) {
    return std::clamp(int(all / std::max<std::size_t>(1, samples)), least, most);
}

// Where samples are chosen, so that they stay in place on a body that moves.
const std::vector<Vec3f>& restPoints(const ShellObject& o) {
    return o.pose ? o.pose->atRest().points : o.boundary->inner;
}

template<class T>
std::string hashOf(const std::vector<T>& values) {
    return contentHashOf({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
}

// How many samples a core asks for: half the shortest length over which its light spreads apart, closer where a tenth
// of the object is thinner than that.
double wantedSamples(const ShellObject& o, std::uint64_t seed) {
    double length = 1e30;
    for (int c = 0; c < 3; ++c) {
        if (o.core.sigmaSPrime[c] > 0) {
            length = std::min(length, CoreResponse::spreadLength(o.core.sigmaA[c], o.core.sigmaSPrime[c]));
        }
    }
    double spacing = kSpacing * length;
    if (!o.pose) {
        const BoundarySamples probes = spreadSamples(o.boundary->inner, o.surface->triangles, kProbes, seed);
        std::vector<float> thickness;
        for (const TrianglePlace& p : probes.places) {
            const Vec3i& t = o.surface->triangles[p.triangle];
            thickness.push_back(localThickness(*o.rayMesh, pointAt(o.boundary->inner, t, p),
                                               -normalize(pointAt(o.surface->normals, t, p))) *
                                o.mmPerUnit);
        }
        if (!thickness.empty()) {
            const auto tenth = thickness.begin() + std::ptrdiff_t(thickness.size() / 10);
            std::nth_element(thickness.begin(), tenth, thickness.end());
            spacing = std::min(spacing, std::max(0.7 * double(*tenth), kFinestSpacing* length));
        }
    }
    const double units = double(o.mmPerUnit) * double(o.mmPerUnit);
    return surfaceArea(restPoints(o), o.surface->triangles) * units / (spacing * spacing);
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

std::shared_ptr<const ShellCore> ShellCores::prepare(const ShellObject& o, std::uint64_t seed, Progress& progress) {
    char text[300];
    const auto number = [&](double x) {
        std::snprintf(text, sizeof text, "%.17g;", x);
        return std::string(text);
    };
    std::string sampleKey = hashOf(restPoints(o)) + hashOf(o.surface->triangles) + number(double(seed));
    std::string key = hashOf(o.boundary->inner) + number(double(o.mmPerUnit)) + number(double(int(o.coreModel)));
    for (int c = 0; c < 3; ++c) {
        key += number(o.core.sigmaA[c]) + number(o.core.sigmaSPrime[c]);
    }
    key += sampleKey;
    std::shared_ptr<const ShellCore> core = cores_.find(key);
    if (!core) {
        auto made = std::make_shared<ShellCore>();
        made->wanted = wantedSamples(o, seed);
        const std::size_t count = std::size_t(std::clamp(made->wanted, double(kMinSamples), double(kMaxSamples)));
        sampleKey += number(double(count));
        made->samples = samples_.find(sampleKey);
        if (!made->samples) {
            made->samples = samples_.keep(sampleKey, spreadSamples(restPoints(o), o.surface->triangles, count, seed));
        }
        const CoreBoundary boundary{o.boundary->inner, o.surface->triangles, o.surface->normals,
                                    *o.rayMesh,        *made->samples,       double(o.mmPerUnit)};
        made->response = std::make_shared<const CoreResponse>(o.core, boundary, o.coreModel, seed, progress);
        const SurfacePoints& samples = made->response->samples();
        double area = 0;
        for (float a : samples.areas) {
            area += double(a);
        }
        std::vector<Vec3f> places = o.boundary->inner;
        for (Vec3f& p : places) {
            p *= o.mmPerUnit;
        }
        const double spacing = std::sqrt(area / double(std::max<std::size_t>(1, samples.areas.size())));
        made->toSurface = SampleFilter(samples, places, o.surface->normals, {float(spacing) * kFilterSpacings});
        int used = std::snprintf(text, sizeof text, "%zu samples %.3g mm apart", samples.areas.size(), spacing);
        if (made->wanted > double(kMaxSamples)) {
            used += std::snprintf(text + used, sizeof text - std::size_t(used), " (%.3g asked for, cut)", made->wanted);
        }
        if (const std::size_t walked = made->response->walkedSamples()) {
            used +=
                std::snprintf(text + used, sizeof text - std::size_t(used), ", %.0f %% thin, by %zu walks each",
                              100.0 * double(walked) / double(samples.areas.size()), made->response->walksPerSample());
        }
        if (const std::size_t terms = made->response->meanTerms()) {
            used += std::snprintf(text + used, sizeof text - std::size_t(used), ", dipoles of %zu terms", terms);
        }
        made->summary = text;
        core = cores_.keep(key, std::move(made));
    }
    asked_.push_back(core);
    return core;
}

void ShellCores::dropUnused() {
    cores_.dropUnused();
    samples_.dropUnused();
    asked_.clear();
}

std::vector<Rgb> coreRadiance(const ShellCore& core, const ShellObject& o, const Transform& objectToWorld,
                              const PreparedScene& scene, bool bounces, std::uint64_t seed, Progress& progress) {
    const BoundarySamples& at = *core.samples;
    const std::size_t count = at.count();
    if (count == 0) {
        return std::vector<Rgb>(o.surface->points.size(), Rgb(0.0f));
    }
    const LightSet& lights = scene.lights;
    const Dipole dipoles[3] = {{o.core.sigmaA.x, o.core.sigmaSPrime.x},
                               {o.core.sigmaA.y, o.core.sigmaSPrime.y},
                               {o.core.sigmaA.z, o.core.sigmaSPrime.z}};
    double areaMm2 = 0;
    for (float a : core.response->samples().areas) {
        areaMm2 += double(a);
    }
    const ColumnMaps maps(*o.table, 0.5 * std::sqrt(areaMm2 / double(count)));
    CoreLight s(count);
    const Transform worldToObject = objectToWorld.inverse();
    const Vec3i size = o.table->size;
    const float offset = 1e-3f * o.grid->voxelSize();
    const int domeSamples = raysPerSample(kDomeRays, count, 8, 96);
    const int nearSamples = raysPerSample(kNearRays, count, 2, 8);
    const int bounceSamples = bounces ? raysPerSample(kBounceRays, count, 4, 32) : 0;

    parallelFor(count, 16, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        SceneRays rays(scene);
        PlainShader plain(scene, rays);
        for (std::size_t i = begin; i < end; ++i) {
            const TrianglePlace place = at.places[i];
            const Vec3i& tri = o.surface->triangles[place.triangle];
            const ShellLookup frame = frameAt(o, place.triangle, place.b1, place.b2);
            const Vec3f outer = pointAt(o.surface->points, tri, place);
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
            const auto startAt = [&](const Vec3f& point) {
                return Vec3f(objectToWorld.point(Vec3d(point + frame.normal * offset))) + worldNormal * scene.rounding;
            };
            // What a direction brings through the shell.
            const auto shine = [&](const Vec3f& local, const Rgb& in) {
                const DirectionWeights w = o.table->directions.weights(local);
                const Rgb all = ColumnMaps::blend(maps.transmitted, column, w);
                const Rgb direct = ColumnMaps::blend(maps.direct, column, w);
                // The core has the index of the shell: what has not collided arrives at the refracted angle. Its share
                // is that of the table's own, scaled medium (DESIGN 3.10).
                const double cosine = double(fresnel(local.z, ior).cosT);
                s.diffuse[i] += in * (all - direct);
                for (int c = 0; c < 3; ++c) {
                    const double diffuse = dipoles[c].diffuseAlbedo();
                    // Without scattering there is no such ratio: what crosses the core counts as it is.
                    const double ratio = diffuse > 0 ? dipoles[c].directAlbedo(cosine) / diffuse : 1.0;
                    s.direct[i][c] += in[c] * direct[c] * float(ratio);
                }
            };
            const auto inTile = [&](const Vec3f& towards) {
                return tile.toTile(normalize(Vec3f(worldToObject.vector(Vec3d(towards)))));
            };
            LightPick picks[kMaxLights];
            PixelSampler chooser(seed, i, 0);
            const int chosen = lights.choose(worldPoint, worldNormal, chooser.next1d(), kMaxLights, picks);
            for (int p = 0; p < chosen; ++p) {
                const std::size_t l = picks[p].light;
                const int n = lights.isDome(l) ? domeSamples : nearSamples;
                for (int k = 0; k < n; ++k) {
                    PixelSampler sampler(seed + 17 * l, i, std::uint32_t(k));
                    const Vec2f u = sampler.next2d(), v = sampler.next2d();
                    const LightSample light = lights.sample(l, worldPoint, worldNormal, u);
                    const Vec3f local = inTile(light.towards);
                    if (!(local.z > 0) || !(maxComponent(light.irradiance) > 0)) {
                        continue;
                    }
                    const Rgb visible = rays.visibility(
                        startAt(jitterOnSurface(*o.rayMesh, outer, frame.normal, o.blurRadiusMm / o.mmPerUnit, v)),
                        light);
                    if (maxComponent(visible) > 0) {
                        // A mesh that is a light is met by bounced rays as well: each way has its share.
                        const float share = bounces ? PlainShader::besideBounced(light, worldNormal, 1) : 1.0f;
                        shine(local, light.irradiance * visible * (share * picks[p].weight / float(n)));
                    }
                }
            }
            for (int k = 0; k < bounceSamples; ++k) {
                PixelSampler sampler(seed + kBounceSeed, i, std::uint32_t(k));
                const LightSample light = plain.bounced(startAt(outer), worldNormal, 1, sampler);
                const Vec3f local = inTile(light.towards);
                if (local.z > 0 && maxComponent(light.irradiance) > 0) {
                    shine(local, light.irradiance / float(bounceSamples));
                }
            }
        }
    });

    CoreSolver solver(core.response, std::move(s));
    solver.solve(progress);
    std::vector<Rgb> radiance = core.toSurface.apply(solver.exitance());
    for (Rgb& r : radiance) {
        r = r / kPi;
    }
    return radiance;
}

} // namespace stf
