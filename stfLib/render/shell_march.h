// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/sampler.h"
#include "stfLib/render/shell_object.h"

namespace stf {

/// One light direction of a camera path, object space, with the visibility already in it.
struct ShellLight {
    Vec3f towards;   ///< unit
    Rgb forSingle;   ///< perpendicular irradiance, exact visibility
    Rgb forMultiple; ///< perpendicular irradiance, visibility averaged over the diffusion disc
};

/// Radiance that a camera ray collects in a shell, and what is left of it.
struct ShellRadiance {
    Rgb single{0.0f}, multiple{0.0f}, core{0.0f};
    Rgb transmittance{1.0f}; ///< of the way to `tExit`; zero where the ray ended in the core
    float tExit = 0;         ///< object units from the entry
    bool reachedCore = false;
};

/// Marches object-space rays through one shell (the talk's equations for L_T and I_b, index 1):
///   L = INT Tr kappa a [ f I_0 exp(-depth to light) + (I_0 I_m(w_l) + L_core I_b) / 4 pi ] ds + Tr L_core
/// with exact steps at the crossings of tile voxels and the weights of optics/step_weights.h. Multiple scattering is
/// summed over all steps; single scattering is taken at one step, chosen by its weight (unbiased).
/// One march per thread and object: it holds a grid accessor.
class ShellMarch {
public:
    ShellMarch(const ShellObject& object, const Rgb* coreRadiancePerSample)
        : object_(object), accessor_(object.grid), core_(coreRadiancePerSample) {}

    /// `entry` lies on the surface, `direction` is unit and goes inward; both object space. Distances count from the
    /// entry, so that a far camera costs no precision.
    ShellRadiance march(const Vec3f& entry, const Vec3f& direction, const ShellLight* lights, int lightCount,
                        PixelSampler& sampler);

    /// What the shell looks like at a point: frame and exemplar coordinate.
    bool lookup(const Vec3f& point, ShellLookup& out) { return accessor_.lookup(point, out, core_); }

private:
    const ShellObject& object_;
    ShellGrid::Accessor accessor_;
    const Rgb* core_;
};

/// A unit direction in the frame (tangent, bitangent, normal) that the exemplar has at a lookup. Mirrored coordinates
/// flip the bitangent, as the tile itself is flipped.
Vec3f toTileFrame(const ShellLookup& at, const Vec3f& direction);

} // namespace stf
