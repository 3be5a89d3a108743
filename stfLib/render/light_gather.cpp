// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_gather.h"

#include "stfLib/base/hemisphere.h"
#include "stfLib/base/parallel.h"
#include "stfLib/render/plain_shader.h"

#include <mutex>

namespace stf {

namespace {

constexpr std::size_t kGrain = 16;
constexpr std::uint64_t kChoiceSeed = 0x63686f696365;
constexpr float kFilterSpacings = 2.0f; // radius within which samples make the light of a point

} // namespace

SurfaceSampling::SurfaceSampling(const ShellObject& o, std::size_t wanted, std::uint64_t seed)
    : samples(spreadSamples(o.pose ? o.pose->atRest().points : o.surface->points, o.surface->triangles, wanted, seed)) {
    SurfacePoints at;
    std::vector<Vec3f> places = o.surface->points;
    for (Vec3f& p : places) {
        p *= o.mmPerUnit;
    }
    at.areas = samples.areas(places, o.surface->triangles);
    double area = 0;
    for (std::size_t i = 0; i < samples.count(); ++i) {
        const TrianglePlace& p = samples.places[i];
        const Vec3i& t = o.surface->triangles[p.triangle];
        at.positions.push_back(pointAt(places, t, p));
        at.normals.push_back(normalize(pointAt(o.surface->normals, t, p)));
        area += double(at.areas[i]);
    }
    spacingMm = float(std::sqrt(area / double(std::max<std::size_t>(1, samples.count()))));
    const NearestSample find(at, spacingMm);
    nearest.resize(places.size());
    for (std::size_t i = 0; i < places.size() && samples.count() > 0; ++i) {
        nearest[i] = find.find(places[i], o.surface->normals[i]);
    }
    toSurface = SampleFilter(at, places, o.surface->normals, {spacingMm * kFilterSpacings});
}

LightGather::LightGather(const PreparedInstance& instance, const PreparedScene& scene,
                         std::shared_ptr<const SurfaceSampling> sampling, int raysPerSample, std::uint64_t seed,
                         Progress& progress)
    : sampling_(std::move(sampling)), raysPerSample_(raysPerSample) {
    const BoundarySamples& samples = sampling_->samples;
    const std::size_t count = samples.count();
    const ShellObject& shell = *instance.mesh->shell;
    const float offset = 1e-3f * shell.grid->voxelSize();
    normals_.resize(count);
    std::vector<std::vector<Way>> ways((count + kGrain - 1) / kGrain);
    std::mutex mutex;
    parallelFor(count, kGrain, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        SceneRays rays(scene);
        PlainShader plain(scene, rays);
        for (std::size_t i = begin; i < end; ++i) {
            Ray ray;
            const RayHit here = hitAt(instance, samples.places[i]);
            const Surfel surfel = surfelAt(instance, ray, here);
            const Vec3f& normal = normals_[i] = surfel.normal;
            const Vec3f lifted = surfel.shadowOrigin + instance.objectNormal(normal) * offset;
            ray.origin = instance.worldPoint(lifted) + normal * scene.rounding;
            Vec3f x, y;
            orthonormalBasis(normal, x, y);
            for (int k = 0; k < raysPerSample_; ++k) {
                PixelSampler sampler(seed, i, std::uint32_t(k));
                const Vec3f d = cosineHemisphere(sampler.next2d());
                ray.direction = normalize(x * d.x + y * d.y + normal * d.z);
                const PlainShader::Sight sight = plain.look(ray, sampler);
                if (maxComponent(sight.weight) > 0 || maxComponent(sight.radiance) > 0) {
                    const RayHit& at = sight.hit;
                    ways[begin / kGrain].push_back({std::uint32_t(i), ray.direction, sight.radiance, sight.weight,
                                                    at.instance, at.triangle, at.u, at.v});
                }
            }
        }
        const std::lock_guard<std::mutex> lock(mutex);
        rays_ += rays.count();
    });
    for (const std::vector<Way>& w : ways) {
        ways_.insert(ways_.end(), w.begin(), w.end());
    }
}

std::size_t LightGather::markSeen(std::vector<char>& seen) const {
    std::size_t links = 0;
    for (const Way& w : ways_) {
        if (maxComponent(w.weight) > 0) {
            seen[w.instance] = 1;
            ++links;
        }
    }
    return links;
}

IndirectLight LightGather::light(const PreparedScene& scene) const {
    const std::size_t count = normals_.size();
    IndirectLight out;
    out.sample = sampling_->nearest;
    out.directions.resize(count * IndirectLight::kDirections);
    std::vector<std::size_t> first(count + 1, ways_.size());
    for (std::size_t w = ways_.size(); w-- > 0;) {
        first[ways_[w].sample] = w;
    }
    for (std::size_t i = count; i-- > 0;) {
        first[i] = std::min(first[i], first[i + 1]);
    }
    std::vector<Rgb> mean(count);
    parallelFor(count, 64, [&](std::size_t begin, std::size_t end) {
        std::vector<IndirectRay> rays;
        for (std::size_t i = begin; i < end; ++i) {
            rays.clear();
            Rgb sum(0.0f);
            for (std::size_t w = first[i]; w < first[i + 1]; ++w) {
                const Way& way = ways_[w];
                Rgb radiance = way.plain;
                if (maxComponent(way.weight) > 0) {
                    radiance += way.weight * exitantAt(scene.instances[way.instance], way.triangle, way.u, way.v);
                }
                rays.push_back({way.towards, radiance});
                sum += radiance;
            }
            mean[i] = sum / float(raysPerSample_);
            PixelSampler sampler(kChoiceSeed, i, 0);
            chooseDirections(rays, normals_[i], sampler.next1d(), &out.directions[i * IndirectLight::kDirections]);
        }
    });
    out.mean = sampling_->toSurface.apply(mean);
    return out;
}

} // namespace stf
