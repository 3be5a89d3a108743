// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/sampler.h"
#include "stfLib/base/vec.h"

#include <cstdint>
#include <vector>

namespace stf {

/// Light that a shell's surface gets from other surfaces: radiance for points of the surface, and where it comes from
/// for samples of it.
struct IndirectLight {
    static constexpr int kDirections = 32; ///< kept for a sample

    std::vector<Rgb> mean;             ///< per point: radiance, mean by the cosine to the normal: irradiance / pi
    std::vector<std::uint32_t> sample; ///< per point: the sample that is nearest
    /// Per sample, kDirections of them: unit, world, each for the same share of the irradiance; those that are high
    /// above the surface come first.
    std::vector<Vec3f> directions;

    bool empty() const { return mean.empty(); }
};

/// Rays of one sample, and what they brought.
struct IndirectRay {
    Vec3f towards;
    Rgb radiance;
};
/// Chooses kDirections of rays, which were drawn by the cosine to `normal`, by how bright they are: systematic
/// resampling in the order of their height (Kitagawa 1996), `u` in [0, 1). Dark samples look along the normal.
void chooseDirections(std::vector<IndirectRay>& rays, const Vec3f& normal, float u, Vec3f* directions);

/// Directions that stand for all the light of a point, and the perpendicular irradiance of each (world): one of the
/// upper and one of the lower half. Together they bring the whole irradiance, so that what noise is left comes from how
/// differently directions go through a shell.
struct IndirectSample {
    static constexpr int kDirections = 2;
    Vec3f towards[kDirections];
    Rgb irradiance[kDirections];
};
/// At (u, v) of a triangle whose corners are points of the surface; `normal`: there, unit, world.
IndirectSample sampleIndirect(const IndirectLight& light, const Vec3i& corners, float u, float v, const Vec3f& normal,
                              PixelSampler& sampler);

} // namespace stf
