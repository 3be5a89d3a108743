// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_gather.h"

#include "stfLib/base/hemisphere.h"
#include "stfLib/base/parallel.h"
#include "stfLib/render/plain_shader.h"

#include <mutex>

namespace stf {

namespace {

constexpr std::size_t kGrain = 16;
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
    plain_.resize(count);
    std::vector<std::vector<Link>> links((count + kGrain - 1) / kGrain);
    std::mutex mutex;
    parallelFor(count, kGrain, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        SceneRays rays(scene);
        PlainShader plain(scene, rays);
        bool dark = true;
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
                if (maxComponent(sight.weight) > 0) {
                    const RayHit& at = sight.hit;
                    links[begin / kGrain].push_back(
                        {std::uint32_t(i), at.instance, at.triangle, at.u, at.v, sight.weight, ray.direction});
                }
                if (maxComponent(sight.radiance) > 0) {
                    plain_[i].add(ray.direction, sight.radiance);
                    dark = false;
                }
            }
        }
        const std::lock_guard<std::mutex> lock(mutex);
        rays_ += rays.count();
        dark_ = dark_ && dark;
    });
    for (const std::vector<Link>& l : links) {
        links_.insert(links_.end(), l.begin(), l.end());
    }
}

std::size_t LightGather::markSeen(std::vector<char>& seen) const {
    for (const Link& l : links_) {
        seen[l.instance] = 1;
    }
    return links_.size();
}

std::vector<IndirectLight> LightGather::light(const PreparedScene& scene) const {
    std::vector<IndirectSum> sums = plain_;
    for (const Link& l : links_) {
        sums[l.sample].add(l.towards, l.weight * exitantAt(scene.instances[l.instance], l.triangle, l.u, l.v));
    }
    std::vector<Rgb> mean(sums.size());
    std::vector<Vec3f> slope(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const IndirectLight light = sums[i].light(raysPerSample_, normals_[i]);
        mean[i] = light.mean;
        slope[i] = light.slope;
    }
    mean = sampling_->toSurface.apply(mean);
    slope = sampling_->toSurface.apply(slope);
    std::vector<IndirectLight> all(mean.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        all[i] = relative({mean[i], slope[i]});
    }
    return all;
}

} // namespace stf
