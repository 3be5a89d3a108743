// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/sampler.h"
#include "stfLib/render/prepared_scene.h"

#include <functional>
#include <unordered_map>

namespace stf {

constexpr int kMaxLightsPerPath = 4; // more are chosen from at random, so that cost stays bounded
/// A dome is half hidden by the ground and by the object itself: several directions a path cost less than more paths.
constexpr int kDomeDirections = 2;

/// The rays of one thread through a prepared scene, counted.
class SceneRays {
public:
    explicit SceneRays(const PreparedScene& scene) : scene_(scene) {}

    /// When the rays to come are, of the exposure: 0 to 1.
    void setTime(float time) {
        time_ = time;
        ++timeVersion_;
    }
    bool intersect(const Ray& ray, RayHit& hit) {
        ++count_;
        return scene_.rays->intersect(ray, hit, time_);
    }
    /// Where an instance is at that time. The reference holds until the time is set again.
    const PreparedInstance& instance(std::uint32_t index) {
        const PreparedInstance& placed = scene_.instances[index];
        return placed.motion.empty() ? placed : moved(placed);
    }
    /// Nearest hits of up to kMostTogether rays of neighbouring pixels.
    void intersectTogether(const Ray* rays, const float* times, int count, RayHit* hits, bool* met) {
        count_ += std::uint64_t(count);
        scene_.rays->intersectTogether(rays, times, count, hits, met);
    }
    /// How light gets out of shells that points lie in: moves the origin (world) there, gives what is left.
    using WayOut = std::function<Rgb(Vec3f& origin, LightSample& light)>;
    /// For the points asked for from now on; null: they lie in no shell.
    void setWayOut(WayOut wayOut) { wayOut_ = std::move(wayOut); }
    /// What a shell leaves of a straight ray that meets its surface; moves the ray's start to where it leaves.
    using ThroughShell = std::function<Rgb(const PreparedInstance&, Ray&, const RayHit&, PixelSampler&)>;
    /// Null: shells stop light.
    void setThroughShell(ThroughShell throughShell) { throughShell_ = std::move(throughShell); }
    /// Links of who asks for lights from now on.
    void setReceiver(const PreparedInstance& instance) { receiver_ = instance.links; }
    /// The share of a light that arrives at a point (world): 0 or 1, but for surfaces that are not opaque. With
    /// numbers for `throughShells` also the light that goes straight through shells, as paths of bounces do.
    Rgb visibility(const Vec3f& origin, const LightSample& light, PixelSampler* throughShells = nullptr);
    /// What is left of a ray at the end of it, through surfaces that are not opaque. `shading`: links of what stops
    /// light; 0: everything does.
    Rgb throughSurfaces(Ray ray, std::uint64_t shading, PixelSampler* throughShells);
    /// The same of a ray that leaves a surface, for lights of which only some prims throw shadows; asked for numbers
    /// while it is used.
    LightSet::Reach reachOf(const Ray& ray, PixelSampler& sampler);
    /// What is left of a ray that goes straight on where it hits something; moves its start behind that.
    Rgb straightOn(Ray& ray, const RayHit& hit, PixelSampler* throughShells);
    /// At most kMaxLightsPerPath of the lights, with their weights; returns how many.
    int chooseLights(const Vec3f& point, const Vec3f& normal, PixelSampler& sampler, LightPick* picks) const;

    std::uint64_t count() const { return count_; }
    void add(std::uint64_t rays) { count_ += rays; }

private:
    struct Moved {
        PreparedInstance instance;
        std::uint64_t timeVersion = 0;
    };
    Rgb fromWithin(Vec3f origin, LightSample light, PixelSampler* throughShells);
    const PreparedInstance& moved(const PreparedInstance& placed);

    const PreparedScene& scene_;
    WayOut wayOut_;
    ThroughShell throughShell_;
    std::uint64_t count_ = 0;
    float time_ = 0.5f;
    std::uint64_t timeVersion_ = 1;
    std::uint64_t receiver_ = kAllLinks;
    std::unordered_map<std::uint32_t, Moved> moved_; ///< of the moving instances that were met
};

} // namespace stf
