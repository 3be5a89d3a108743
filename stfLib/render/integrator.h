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
        : scene_(scene), rays_(scene), plain_(scene, rays_), marches_(scene.instances.size()) {}

    /// `cone`: of the pixel, so that shells are read no finer than it sees.
    /// `time`: of the exposure, 0 to 1; all rays of the path are then.
    PixelSample sample(const Ray& first, const RayCone& cone, PixelSampler& sampler, float time = 0.5f);
    /// The first surface along a ray, for the AOVs that are not averaged.
    PixelHit firstHit(Ray ray, const Camera& camera);
    std::uint64_t rays() const { return rays_.count(); }

private:
    /// Lights of a path that enters a shell, with their visibility; `lights` has room for kMaxShellLights. `indirect`:
    /// with light from plain surfaces. How many.
    int lightsOnShell(const PreparedInstance& instance, const Surfel& surfel, bool indirect, PixelSampler& sampler,
                      ShellLight* lights);
    /// `direction`: unit, object space, inside the shell; `footprintMm`: width of what the pixel sees there.
    ShellRadiance shadeShell(const PreparedInstance& instance, const Surfel& surfel, const Vec3f& direction,
                             float footprintMm, bool indirect, PixelSampler& sampler);
    /// The ray that leaves a refracting shell at the far side, and the share of light that comes in there.
    Ray leaveShell(const PreparedInstance& instance, const Surfel& entry, const Vec3f& direction,
                   const ShellRadiance& through, float& share);
    /// `hit`: of the limit surface; `direction`: unit, object space, as the ray comes.
    ReliefRadiance shadeRelief(const PreparedInstance& instance, const Surfel& surfel, const RayHit& hit,
                               const Vec3f& direction, float footprintMm, bool indirect, PixelSampler& sampler);
    /// The world ray that goes on where a path has left a shell.
    Ray leaveRelief(const PreparedInstance& instance, const ShellExit& exit) const;
    ShellMarch& marchOf(const PreparedInstance& instance);

    const PreparedScene& scene_;
    SceneRays rays_;
    PlainShader plain_;
    std::vector<std::unique_ptr<ShellMarch>> marches_;
};

} // namespace stf
