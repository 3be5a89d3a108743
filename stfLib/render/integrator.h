// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/camera.h"
#include "stfLib/render/film.h"
#include "stfLib/render/plain_shader.h"
#include "stfLib/render/prepared_scene.h"
#include "stfLib/render/shell_march.h"
#include "stfLib/render/surface_crossing.h"

#include <memory>

namespace stf {

/// Follows camera rays through a prepared scene. One per thread: it holds the accessors of the shells it met.
class Integrator {
public:
    explicit Integrator(const PreparedScene& scene)
        : scene_(scene), rays_(scene), plain_(scene, rays_), marches_(scene.instances.size()) {
        rays_.setThroughShell([this](const PreparedInstance& instance, Ray& ray, const RayHit& hit,
                                     PixelSampler& sampler) { return throughShell(instance, ray, hit, sampler); });
    }
    Integrator(const Integrator&) = delete;
    Integrator& operator=(const Integrator&) = delete;

    /// Camera rays of neighbouring pixels and what they meet first: found together, several times as fast.
    struct Bundle {
        Ray ray[kMostTogether];
        RayHit hit[kMostTogether];
        bool met[kMostTogether];
        float time[kMostTogether]; ///< of the exposure, 0 to 1: all rays of the path are then
        int count = 0;
    };
    /// Fills in what the bundle's rays meet.
    void meet(Bundle& bundle) {
        rays_.intersectTogether(bundle.ray, bundle.time, bundle.count, bundle.hit, bundle.met);
    }
    /// A sample of a pixel along the i-th ray of a bundle. `cone`: of the pixel, so that shells are read no finer than
    /// it sees.
    PixelSample sample(const Bundle& bundle, int i, const RayCone& cone, PixelSampler& sampler);
    /// The first surface along it, for the AOVs that are not averaged.
    PixelHit firstHit(const Bundle& bundle, int i, const Camera& camera);
    /// What a shell scatters or shines with towards where a ray (world) comes from that meets it at `hit`; light that
    /// only passes through it, and mirror images, are left out. `footprintMm`: how much of it is seen.
    Rgb scattered(const PreparedInstance& instance, const Ray& ray, const RayHit& hit, float footprintMm,
                  PixelSampler& sampler);
    std::uint64_t rays() const { return rays_.count(); }

private:
    /// Of other lights on a shell: their visibility is averaged over a disc.
    static constexpr int kNearDirections = 1;
    static constexpr int kMaxShellLights = kMaxLightsPerPath * kDomeDirections + IndirectSample::kDirections;
    static_assert(kMaxShellLights <= TileLights::kMost);

    /// Lights of a path that enters a shell, with their visibility; `lights` has room for kMaxShellLights. `indirect`:
    /// with light from plain surfaces. How many.
    int lightsOnShell(const PreparedInstance& instance, const Surfel& surfel, bool indirect, PixelSampler& sampler,
                      ShellLight* lights);
    /// A shell as a ray meets it from outside: what it adds, and the two ways on.
    struct ShellMeeting {
        Rgb single{0.0f}, multiple{0.0f}, core{0.0f};
        Rgb reflection{0.0f};               ///< of these, seen in its relief
        Rgb through{0.0f}, reflected{0.0f}; ///< what is left of the path either way
        Ray onward, mirrorRay;
        float moved = 0, mirrorMoved = 0; ///< from the ray's origin to those of the two
        bool stopped = false;             ///< `onward` begins inside, before what else is met there
    };
    /// The same by what is kept of its light, for paths that see no detail.
    ShellMeeting meetKept(const PreparedInstance& instance, const Surfel& surfel, const Ray& ray, const RayHit& hit);
    static SurfaceCrossing enterShell(const PreparedInstance& instance, float ior, const Vec3f& direction,
                                      const RayHit& hit);
    void mirrorOff(const PreparedInstance& instance, const Surfel& surfel, const SurfaceCrossing& crossing,
                   ShellMeeting& meeting) const;
    /// `medium`: radiance around the ray over that in air.
    ShellMeeting meetShell(const PreparedInstance& instance, const Surfel& surfel, const Ray& ray, const RayHit& hit,
                           float medium, float footprintMm, bool indirect, PixelSampler& sampler);
    /// `direction`: unit, object space, inside the shell; `footprintMm`: width of what the pixel sees there.
    ShellRadiance shadeShell(const PreparedInstance& instance, const Surfel& surfel, const Vec3f& direction,
                             float footprintMm, bool indirect, PixelSampler& sampler);
    /// The ray that leaves a refracting shell at the far side, and the share of light that comes in there.
    Ray leaveShell(const PreparedInstance& instance, const Vec3f& entry, const Vec3f& direction,
                   const ShellRadiance& through, float& share);
    /// `hit`: of the limit surface; `direction`: unit, object space, as the ray comes.
    ReliefRadiance shadeRelief(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit,
                               const Vec3f& direction, float footprintMm, bool indirect, PixelSampler& sampler);
    /// The world ray that goes on where a path has left a shell.
    Ray leaveRelief(const PreparedInstance& instance, const ShellExit& exit) const;
    /// A path that begins inside a shell (shell_interior.cpp).
    struct Interior {
        bool inside = false;  ///< false: it does not
        bool stopped = false; ///< by what `onward` meets next; else the shell is left
        Rgb single{0.0f}, multiple{0.0f}, core{0.0f};
        Rgb through{0.0f}; ///< what is left of the path
        Ray onward;
        float moved = 0; ///< from the ray's origin to that of `onward`
        float index = 1; ///< of refraction where it begins
    };
    Interior crossInterior(const PreparedInstance& instance, const LightPath& path, const RayCone& cone,
                           PixelSampler& sampler);
    /// Object units from a point of a shell along a unit direction to what else is met in it: the front of another
    /// shell or any other surface, but nothing beyond the shell's own surface; infinity: nothing.
    float obstacle(const PreparedInstance& instance, const Vec3f& point, const Vec3f& direction);
    Ray goOnWithin(const PreparedInstance& instance, const ShellExit& stop) const;
    /// Finds the shells that a camera ray begins in. False in a core, with the radiance that is seen there.
    bool startWithin(LightPath& path, Rgb& radiance);
    /// How light gets to a point (world) inside a shell: what the shell leaves of it on a straight way; moves the point
    /// out. Refraction is left aside.
    Rgb lightThrough(const PreparedInstance& instance, Vec3f& origin, LightSample& light, PixelSampler& sampler);
    /// What a shell that does not bend rays leaves of one that meets it; moves the ray's start to its other side. Zero
    /// where something else is met inside.
    Rgb throughShell(const PreparedInstance& instance, Ray& ray, const RayHit& hit, PixelSampler& sampler);
    /// Of a ray that only looks for lights, from inside shells: moves its start out of them.
    void leaveShells(LightPath& path, PixelSampler& sampler);
    /// Sets how light gets to surfaces inside the shells of a path, as long as it lives.
    class WayOutGuard {
    public:
        WayOutGuard(Integrator& integrator, const LightPath& path, PixelSampler& sampler);
        ~WayOutGuard();
        WayOutGuard(const WayOutGuard&) = delete;
        WayOutGuard& operator=(const WayOutGuard&) = delete;

    private:
        Integrator* integrator_ = nullptr;
    };
    float indexWithin(const PreparedInstance& instance, const Vec3f& surfacePoint, std::uint32_t triangle);
    /// What the AOVs say of a shell that a ray meets: of its relief, where it has one. False where the ray passes
    /// through; `hit` is then where it goes on.
    bool seesShell(const PreparedInstance& instance, const Ray& ray, RayHit& hit, const Camera& camera, PixelHit& out);
    void setSeen(const Vec3f& point, const Vec3f& normal, const Camera& camera, PixelHit& out) const;
    ShellMarch& marchOf(const PreparedInstance& instance);

    const PreparedScene& scene_;
    SceneRays rays_;
    PlainShader plain_;
    std::vector<std::unique_ptr<ShellMarch>> marches_;
};

} // namespace stf
