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
    bool stopped = false;        ///< at the span's stop
    bool throughSurface = false; ///< the ray left through the surface at `exit`; else an open rim let it out
    RayHit exit;
};

/// Which part of a ray is marched.
struct ShellSpan {
    bool fromWithin = false;                             ///< it starts inside the shell instead of on its surface
    float stop = std::numeric_limits<float>::infinity(); ///< object units from the start: something else is met there
};

/// Marches object-space rays through one shell: follows the grid's exemplar coordinates and hands straight pieces, one
/// per grid voxel, to a TileMarch (of the tile's level that the footprint asks for); at the end the core shines through
/// what is left of the ray. One march per thread and object: it holds a probe.
class ShellMarch {
public:
    ShellMarch(const ShellObject& object, const Rgb* coreRadiancePerSample);

    /// `entry` lies on the surface, `direction` is unit and goes inward, refracted where the shell refracts; both
    /// object space; `triangle` is the surface's there. Distances count from the entry, so that a far camera costs no
    /// precision. At most TileLights::kMost lights count. `footprintMm`: width of what the pixel sees at the entry; the coarsest level
    /// of the grid that shows it is read.
    ShellRadiance march(const Vec3f& entry, std::uint32_t triangle, const Vec3f& direction, float footprintMm,
                        const ShellLight* lights, int lightCount, PixelSampler& sampler, const ShellSpan& span = {});

    /// The same where a relief refracts: split there, and followed until it leaves.
    ReliefRadiance marchRelief(const ReliefEntry& entry, float footprintMm, const ShellLight* lights, int lightCount,
                               PixelSampler& sampler);

    /// What a ray meets first in a shell with a relief, as its sample is: unshifted, the finest there is. False where
    /// it leads out again.
    bool firstSight(const ReliefEntry& entry, ReliefSight& out);
    /// Albedo of the uppermost material at a place, from a depth (mm) downward; of a blend where there is one. Black
    /// where there is none.
    Rgb albedoAt(const ShellLookup& at, float fromMm) const;

    /// Index of refraction of a flat shell's material at a point of a triangle of the surface; 1 where the grid has
    /// none.
    float iorAt(const Vec3f& surfacePoint, std::uint32_t triangle);

    /// Whether a point lies between the surface and the inner boundary, as seen along a direction (unit); what the
    /// grid has there.
    bool holds(const Vec3f& point, const Vec3f& direction, ShellLookup& at);
    /// Whether it lies in the core of a closed shell, and the radiance over n^2 that leaves the core where the
    /// direction leads.
    bool coreHolds(const Vec3f& point, const Vec3f& direction, Rgb& radiance);
    /// Index of refraction around a point that a lookup found, 1 above a relief.
    float iorWithin(const Vec3f& point, const ShellLookup& at) const;

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
