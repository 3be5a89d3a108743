// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/sampler.h"
#include "stfLib/render/prepared_scene.h"

namespace stf {

constexpr int kMaxLightsPerPath = 4; // more are chosen from at random, so that cost stays bounded
/// A dome is half hidden by the ground and by the object itself: several directions a path cost less than more paths.
constexpr int kDomeDirections = 4;

/// The rays of one thread through a prepared scene, counted.
class SceneRays {
public:
    explicit SceneRays(const PreparedScene& scene) : scene_(scene) {}

    bool intersect(const Ray& ray, RayHit& hit) {
        ++count_;
        return scene_.rays->intersect(ray, hit);
    }
    /// Nearest hits of up to kMostTogether rays of neighbouring pixels.
    void intersectTogether(const Ray* rays, int count, RayHit* hits, bool* met) {
        count_ += std::uint64_t(count);
        scene_.rays->intersectTogether(rays, count, hits, met);
    }
    /// The share of a light that arrives at a point (world): 0 or 1, but for surfaces that are not opaque.
    Rgb visibility(const Vec3f& origin, const LightSample& light);
    /// At most kMaxLightsPerPath of the lights, with their weights; returns how many.
    int chooseLights(const Vec3f& point, const Vec3f& normal, PixelSampler& sampler, LightPick* picks) const;

    std::uint64_t count() const { return count_; }
    void add(std::uint64_t rays) { count_ += rays; }

private:
    Rgb throughSurfaces(Ray ray);

    const PreparedScene& scene_;
    std::uint64_t count_ = 0;
};

} // namespace stf
