// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/relief_march.h"

namespace stf {

/// Radiance inside the shell that a camera ray collects there, and what is left of it.
struct ShellRadiance {
    Rgb single{0.0f}, multiple{0.0f}, core{0.0f};
    Rgb transmittance{1.0f}; ///< of the way to `tExit`; zero where the ray ended in the core
    float tExit = 0;         ///< object units from the entry
    bool reachedCore = false;
    bool throughSurface = false; ///< the ray left through the surface at `exit`; else an open rim let it out
    RayHit exit;
};

/// Marches object-space rays through one shell: follows the grid's exemplar coordinates and hands straight pieces, one
/// per grid voxel, to a TileMarch (of the tile's level that the footprint asks for); at the end the core shines through
/// what is left of the ray. One march per thread and object: it holds a probe.
class ShellMarch {
public:
    ShellMarch(const ShellObject& object, const Rgb* coreRadiancePerSample);

    /// `entry` lies on the surface, `direction` is unit and goes inward, refracted where the shell refracts; both
    /// object space; `triangle` is the surface's there. Distances count from the entry, so that a far camera costs no
    /// precision. At most 16 lights count. `footprintMm`: width of what the pixel sees at the entry; the coarsest level
    /// of the grid that shows it is read.
    ShellRadiance march(const Vec3f& entry, std::uint32_t triangle, const Vec3f& direction, float footprintMm,
                        const ShellLight* lights, int lightCount, PixelSampler& sampler);

    /// The same where a relief refracts: split there, and followed until it leaves.
    ReliefRadiance marchRelief(const ReliefEntry& entry, float footprintMm, const ShellLight* lights, int lightCount,
                               PixelSampler& sampler);

    /// Index of refraction of a flat shell's material at a point of a triangle of the surface; 1 where the grid has
    /// none.
    float iorAt(const Vec3f& surfacePoint, std::uint32_t triangle);

private:
    /// Which places of the sample a lookup shows, in voxels of a level.
    BlendPlace blendAt(const ShellLookup& at, const Vec3f& voxelsPerMm) const;

    const ShellObject& object_;
    ShellProbe probe_;
    const Rgb* core_;
    std::vector<TileMarch> tiles_; ///< of the levels of the tile
};

/// The exemplar coordinate (mm) of a point of the surface as a position at the top of the tile, voxel units.
Vec3f topOfTile(const ShellObject& object, const Vec2f& exemplarMm);

} // namespace stf
