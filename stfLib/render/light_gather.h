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
    bool dark() const { return dark_ && links_.empty(); }
    /// At the points of the surface, relative; with what leaves the shells at present (PreparedInstance::exitant).
    std::vector<IndirectLight> light(const PreparedScene& scene) const;

private:
    struct Link {
        std::uint32_t sample, instance, triangle;
        float u, v;
        Rgb weight;
        Vec3f towards;
    };
    std::shared_ptr<const SurfaceSampling> sampling_;
    int raysPerSample_;
    std::vector<Vec3f> normals_; ///< world, of the samples
    std::vector<IndirectSum> plain_;
    std::vector<Link> links_;
    std::uint64_t rays_ = 0;
    bool dark_ = true; ///< no plain surface sends light
};

} // namespace stf
