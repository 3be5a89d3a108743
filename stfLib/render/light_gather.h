// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/core/boundary_samples.h"
#include "stfLib/core/sample_filter.h"
#include "stfLib/render/indirect_light.h"
#include "stfLib/render/prepared_scene.h"

#include <vector>

namespace stf {

/// Samples of a shell's surface, and how values there become values at the surface's points. They stay in place on a
/// body that moves.
struct SurfaceSampling {
    BoundarySamples samples;
    SampleFilter toSurface;
    std::vector<std::uint32_t> nearest; ///< sample, per point of the surface
    float spacingMm = 0;

    SurfaceSampling(const ShellObject& shell, std::size_t wanted, std::uint64_t seed);
};

/// Light that one shell gets from other surfaces: paths from samples of its surface, traced once. From
/// plain surfaces they bring what light these get directly; where they end at shells (the own one included) they name
/// the place, so that what leaves there may change.
class LightGather {
public:
    /// Deterministic by `seed`. Throws Cancelled.
    LightGather(const PreparedInstance& instance, const PreparedScene& scene,
                std::shared_ptr<const SurfaceSampling> sampling, int raysPerSample, std::uint64_t seed,
                Progress& progress);

    const SurfaceSampling& sampling() const { return *sampling_; }
    std::uint64_t rays() const { return rays_; }
    /// Paths that end at shells; `seen`, by instance, is set for these.
    std::size_t markSeen(std::vector<char>& seen) const;
    bool dark() const { return ways_.empty(); }
    /// With what leaves the shells at present (PreparedInstance::exitant).
    IndirectLight light(const PreparedScene& scene) const;

private:
    struct Way {
        std::uint32_t sample;
        Vec3f towards;
        Rgb plain;                        ///< radiance by way of plain surfaces
        Rgb weight;                       ///< of what leaves a shell where the path ends; 0: it does not end at one
        std::uint32_t instance, triangle; ///< of that shell
        float u, v;
    };
    std::shared_ptr<const SurfaceSampling> sampling_;
    int raysPerSample_;
    std::vector<Vec3f> normals_; ///< world, of the samples
    std::vector<Way> ways_;      ///< those that are not dark, by sample
    std::uint64_t rays_ = 0;
};

} // namespace stf
