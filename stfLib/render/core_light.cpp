// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/core_light.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/sampler.h"
#include "stfLib/core/local_thickness.h"
#include "stfLib/optics/fresnel.h"
#include "stfLib/render/scene_rays.h"
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
constexpr double kSpacing = 0.5;            ///< of the spread length, between samples
constexpr double kFinestSpacing = 0.45;     ///< the same where thin parts ask for more
constexpr std::size_t kProbes = 300;        ///< of the thickness
constexpr float kFineTree = 0.1f * CoreResponse::kEpsilon;
constexpr float kFilterSpacings = 1.8f;                 ///< radius within which samples make the exitance of a point
constexpr std::uint64_t kIndirectSeed = 0x626f756e6365; ///< apart from those of lights
constexpr int kIndirectTurns = 4;
constexpr int kMaxLights = 32; ///< of a sample of the core; more are chosen from
/// Rays to a dome and to another light: fewer per sample where samples are many, since the core mixes them anyway.
constexpr std::size_t kDomeRays = 200'000, kNearRays = 80'000;

int raysPerSample(std::size_t all, std::size_t samples, int least, int most) {
    return std::clamp(int(all / std::max<std::size_t>(1, samples)), least, most);
}

// Where samples are chosen, so that they stay in place on a body that moves.
const std::vector<Vec3f>& restPoints(const ShellObject& o) {
    return o.pose ? o.pose->atRest().points : o.boundary->inner;
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
    std::string key = hashOf(o.boundary->inner) + number(double(o.mmPerUnit)) + number(double(int(o.coreModel))) +
                      number(double(o.exact.coreTree));
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
        made->response = std::make_shared<const CoreResponse>(o.core, boundary, o.coreModel, seed, progress,
                                                              CoreResponse::kWalks, o.exact.coreTree ? kFineTree : CoreResponse::kEpsilon);
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
        made->spacingMm = spacing;
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

// A sample of the inner boundary, as seen from the surface above it.
struct CoreLighting::Impl {
    Impl(std::shared_ptr<const ShellCore> c, const PreparedInstance& i, const PreparedScene& s, std::uint64_t seed_)
        : core(std::move(c)), instance(i), scene(s), object(*i.mesh->shell),
          seed(seed_), dipoles{{object.core.sigmaA.x, object.core.sigmaSPrime.x},
                               {object.core.sigmaA.y, object.core.sigmaSPrime.y},
                               {object.core.sigmaA.z, object.core.sigmaSPrime.z}},
          maps(*object.table, 0.5 * core->spacingMm), lit(core->samples->count()) {}

    struct Place {
        TrianglePlace at;
        ShellLookup frame;
        TileFrame tile;
        std::size_t column;
        float ior;
        Vec3f outer, worldNormal, worldPoint;
    };
    Place placeOf(std::size_t sample) const {
        const TrianglePlace at = core->samples->places[sample];
        const ShellLookup frame = frameAt(object, at.triangle, at.b1, at.b2);
        const Vec3d& voxel = object.lit->voxelMm;
        const Vec3i size = object.table->size;
        const int ix = TileTracer::wrap(int(std::floor(frame.exemplar.x / float(voxel.x))), size.x);
        const int iy = TileTracer::wrap(int(std::floor(frame.exemplar.y / float(voxel.y))), size.y);
        const Vec3f outer = pointAt(object.surface->points, object.surface->triangles[at.triangle], at);
        return {at,
                frame,
                TileFrame(frame),
                std::size_t(ix) + std::size_t(size.x) * std::size_t(iy),
                object.medium->ior(topOfTile(object, frame.exemplar)),
                outer,
                instance.worldNormal(frame.normal),
                instance.worldPoint(outer)};
    }
    Vec3f inTile(const Place& place, const Vec3f& towards) const {
        return place.tile.toTile(instance.objectDirection(towards));
    }
    // What a direction (of the tile) brings through the shell.
    void shine(const Place& place, const Vec3f& local, const Rgb& in, Rgb& diffuse, Rgb& direct) const {
        const DirectionWeights w = object.table->directions.weights(local);
        const Rgb all = ColumnMaps::blend(maps.transmitted, place.column, w);
        const Rgb straight = ColumnMaps::blend(maps.direct, place.column, w);
        // The core has the index of the shell: what has not collided arrives at the refracted angle. Its share is that
        // of the table's own, scaled medium (DESIGN 3.10).
        const double cosine = double(fresnel(local.z, place.ior).cosT);
        diffuse += in * (all - straight);
        for (int c = 0; c < 3; ++c) {
            const double albedo = dipoles[c].diffuseAlbedo();
            // Without scattering there is no such ratio: what crosses the core counts as it is.
            const double ratio = albedo > 0 ? dipoles[c].directAlbedo(cosine) / albedo : 1.0;
            direct[c] += in[c] * straight[c] * float(ratio);
        }
    }
    void askLights(std::size_t sample, SceneRays& rays);

    std::shared_ptr<const ShellCore> core;
    const PreparedInstance& instance;
    const PreparedScene& scene;
    const ShellObject& object;
    std::uint64_t seed;
    Dipole dipoles[3];
    ColumnMaps maps;
    CoreLight lit; ///< by lights alone
};

void CoreLighting::Impl::askLights(std::size_t i, SceneRays& rays) {
    const LightSet& lights = scene.lights;
    const Place place = placeOf(i);
    const std::size_t count = core->samples->count();
    const int domeSamples = raysPerSample(kDomeRays, count, 8, 96);
    const int nearSamples = raysPerSample(kNearRays, count, 2, 8);
    const float offset = 1e-3f * object.grid->voxelSize();
    lit.shellReflectance[i] = maps.reflected[place.column];
    if (!maps.emitted.empty()) {
        lit.diffuse[i] += maps.emitted[place.column];
    }
    LightPick picks[kMaxLights];
    PixelSampler chooser(seed, i, 0);
    rays.setReceiver(instance);
    const int chosen = lights.choose(place.worldPoint, place.worldNormal, chooser.next1d(), kMaxLights, picks);
    for (int p = 0; p < chosen; ++p) {
        const std::size_t l = picks[p].light;
        if (scene.keepsDomes && lights.isSmoothDome(l)) {
            continue;
        }
        const int n = lights.isDome(l) ? domeSamples : nearSamples;
        for (int k = 0; k < n; ++k) {
            PixelSampler sampler(seed + 17 * l, i, std::uint32_t(k));
            const Vec2f u = sampler.next2d(), v = sampler.next2d();
            const LightSample light = lights.sample(l, place.worldPoint, place.worldNormal, u);
            const Vec3f local = inTile(place, light.towards);
            if (!(local.z > 0) || !(maxComponent(light.irradiance) > 0)) {
                continue;
            }
            const Vec3f& up = place.frame.normal;
            const Vec3f from =
                jitterOnSurface(*object.rayMesh, place.outer, up, object.blurRadiusMm / object.mmPerUnit, v);
            const Vec3f lifted = instance.worldPoint(from + up * offset) + place.worldNormal * scene.rounding;
            const Rgb visible = rays.visibility(lifted, light);
            if (maxComponent(visible) > 0) {
                shine(place, local, light.irradiance * visible * (picks[p].weight / float(n)), lit.diffuse[i],
                      lit.direct[i]);
            }
        }
    }
}

CoreLighting::CoreLighting(std::shared_ptr<const ShellCore> core, const PreparedInstance& instance,
                           const PreparedScene& scene, std::uint64_t seed, Progress& progress) {
    auto impl = std::make_unique<Impl>(std::move(core), instance, scene, seed);
    parallelFor(impl->core->samples->count(), 16, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        SceneRays rays(scene);
        for (std::size_t i = begin; i < end; ++i) {
            impl->askLights(i, rays);
        }
    });
    impl_ = std::move(impl);
}

CoreLighting::~CoreLighting() = default;

std::vector<Rgb> CoreLighting::radiance(Progress& progress) {
    const Impl& s = *impl_;
    const std::size_t count = s.core->samples->count();
    if (count == 0) {
        return std::vector<Rgb>(s.object.surface->points.size(), Rgb(0.0f));
    }
    CoreLight light = s.lit;
    if (!s.instance.indirect.empty()) {
        parallelFor(count, 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Impl::Place place = s.placeOf(i);
                const Vec3i& corners = s.object.surface->triangles[place.at.triangle];
                for (int k = 0; k < kIndirectTurns; ++k) {
                    PixelSampler sampler(s.seed + kIndirectSeed, i, std::uint32_t(k));
                    const IndirectSample from = sampleIndirect(s.instance.indirect, corners, place.at.b1, place.at.b2,
                                                               place.worldNormal, sampler);
                    for (int d = 0; d < IndirectSample::kDirections; ++d) {
                        if (const Vec3f local = s.inTile(place, from.towards[d]); local.z > 0) {
                            s.shine(place, local, from.irradiance[d] / float(kIndirectTurns), light.diffuse[i],
                                    light.direct[i]);
                        }
                    }
                }
            }
        });
    }
    CoreSolver solver(s.core->response, std::move(light));
    solver.solve(progress, exitance_);
    exitance_ = solver.exitance();
    std::vector<Rgb> radiance = s.core->toSurface.apply(exitance_);
    for (Rgb& r : radiance) {
        r = r / kPi;
    }
    return radiance;
}

} // namespace stf
