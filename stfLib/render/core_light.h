// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/core/core_solver.h"
#include "stfLib/render/prepared_scene.h"
#include "stfLib/render/stage_cache.h"

#include <string>

namespace stf {

/// The response of the core of a shell in its pose, and how exitance at its samples becomes that of the surface.
struct ShellCore {
    std::shared_ptr<const BoundarySamples> samples;
    std::shared_ptr<const CoreResponse> response;
    SampleFilter toSurface; ///< one place per point of the surface
    double spacingMm = 0;   ///< between samples
    double wanted = 0;      ///< samples that half a spread length asks for; `samples` may be fewer
    std::string summary;    ///< for the plan
};

/// Cores of shells, kept as long as a shell is seen with the same boundary and core, so that an edit of a light costs
/// the balance only. One thread at a time.
class ShellCores {
public:
    /// Throws Cancelled.
    std::shared_ptr<const ShellCore> prepare(const ShellObject& shell, std::uint64_t seed, Progress& progress);
    /// Forgets what was not asked for since the last call.
    void dropUnused();

private:
    StageCache<BoundarySamples> samples_;
    StageCache<ShellCore> cores_;
    std::vector<std::shared_ptr<const ShellCore>> asked_; ///< they hold their samples
};

/// The core of one instance under the light that shines through its shell onto samples of the inner boundary. Depends
/// on the scene and the instance's place, not on the camera. Deterministic by `seed`.
class CoreLighting {
public:
    /// Asks the lights of the scene. All must outlive this. Throws Cancelled.
    CoreLighting(std::shared_ptr<const ShellCore> core, const PreparedInstance& instance, const PreparedScene& scene,
                 std::uint64_t seed, Progress& progress);
    ~CoreLighting();
    CoreLighting(const CoreLighting&) = delete;
    CoreLighting& operator=(const CoreLighting&) = delete;

    /// Solves the core's balance for the lights and the instance's indirect light of now: radiance that leaves the core
    /// (B / pi, tile units cancel), per point of the surface. Begins with what it was the last time. Throws Cancelled.
    std::vector<Rgb> radiance(Progress& progress);

private:
    struct Impl;
    std::unique_ptr<const Impl> impl_;
    std::vector<Rgb> exitance_; ///< of the last time
};

/// A point of the surface moved by a random step of at most `radius` (object units) within the tangent plane and put
/// back onto the surface; the point itself where the step leaves it. Visibility for multiple scattering starts there.
Vec3f jitterOnSurface(const RayMesh& mesh, const Vec3f& point, const Vec3f& normal, float radius, Vec2f u);

} // namespace stf
