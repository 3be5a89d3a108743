// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/sampler.h"
#include "stfLib/base/vec.h"

namespace stf {

/// Light that a place of a shell's surface gets from other surfaces: radiance that grows linearly across the
/// hemisphere, fitted to rays by their first moments.
struct IndirectLight {
    Rgb mean{0.0f};    ///< radiance, mean by the cosine to the normal: irradiance / pi
    Vec3f slope{0.0f}; ///< world, of the radiance over its mean, per unit of direction

    IndirectLight operator*(float s) const { return {mean * s, slope * s}; }
    IndirectLight operator+(const IndirectLight& o) const { return {mean + o.mean, slope + o.slope}; }
};

/// Sums of rays that were chosen by the cosine to a normal.
class IndirectSum {
public:
    void add(const Vec3f& towards, const Rgb& radiance) {
        radiance_ += radiance;
        moment_ += towards * average(radiance);
    }
    /// Of `rays` in all. The slope counts by its brightness, so that means of several places can be taken: `relative`
    /// makes it one over the mean.
    IndirectLight light(int rays, const Vec3f& normal) const;

private:
    Rgb radiance_{0.0f};
    Vec3f moment_{0.0f};
};

/// The slope over the mean, at most as steep as keeps radiance from falling below zero in most of the hemisphere.
IndirectLight relative(const IndirectLight& absolute);

/// Directions that stand for the hemisphere, and the perpendicular irradiance of each (world). Their angles to the
/// normal are the nodes of Gauss's rule for two points under a density of cosine / pi, which is exact for cubics in the
/// squared cosine; around the normal they are chosen by how bright it is there. Together they bring the whole
/// irradiance, so that hardly any noise is left. `light` is relative.
struct IndirectSample {
    static constexpr int kDirections = 2;
    Vec3f towards[kDirections];
    Rgb irradiance[kDirections];
};
IndirectSample sampleIndirect(const IndirectLight& light, const Vec3f& normal, PixelSampler& sampler);

} // namespace stf
