// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/tile_march.h"
#include "stfLib/shell/posed_shell.h"

namespace stf {

/// One light direction of a camera path, object space, with the visibility already in it.
struct ShellLight {
    Vec3f towards;   ///< unit, outside
    Rgb forSingle;   ///< perpendicular irradiance, exact visibility
    Rgb forMultiple; ///< perpendicular irradiance, visibility averaged over the diffusion disc
};

/// The frame that the exemplar has at a lookup: tangent, bitangent, normal of the smooth limit surface. Mirrored
/// coordinates flip the bitangent, as the tile itself is flipped.
class TileFrame {
public:
    explicit TileFrame(const ShellLookup& at);
    /// A direction of object space in the frame.
    Vec3f toTile(const Vec3f& d) const { return {dot(d, tangent_), dot(d, bitangent_), dot(d, normal_)}; }

private:
    Vec3f tangent_, bitangent_, normal_;
};

/// The lights of a camera path, turned into the frame of one place after the other.
class TileLights {
public:
    static constexpr int kMost = 18;
    TileLights(const ShellLight* lights, int count);
    /// Sets the frame of a march: of a lookup, for a ray that goes along `direction` (unit, object space).
    void setFrame(const ShellLookup& at, const Vec3f& direction, TileMarch& tile);

private:
    const ShellLight* lights_;
    int count_;
    MarchLight tile_[kMost];
};

/// A straight line in the tile.
struct TileLine {
    Vec3f position, voxelsPerMm;
};

/// What a camera path knows of the tile at a point of the shell, to first order around it.
struct ShellPlace {
    ShellLookup at{};
    Vec3f point; ///< of the lookup
    bool known = false;
    /// The entry is the tile's top, whatever facets and interpolation make of it: in a dense medium a hundredth of a
    /// millimetre would show. The depth (mm) at which the first step would start is taken off all of them.
    float entryDepth = 0;

    /// Looks a point up; where the grid has nothing, false and nothing changes.
    bool find(ShellProbe& probe, const Vec3f& point, const Rgb* core, int level);
    /// Takes the first lookup, `back` (object units) behind the entry along `direction`, for one of the top. `step`:
    /// between lookups.
    void enterHere(const Vec3f& direction, float back, float step, float mmPerUnit);
    /// Carries the lookup on: first order is good over about one voxel of the grid.
    void carry(const Vec3f& direction, float distance, float mmPerUnit);
    /// The line along `direction` that starts `back` (object units) before the lookup. `perMm`: voxels of the tile.
    TileLine lineAlong(const Vec3f& direction, float back, const Vec3f& perMm, float mmPerUnit) const;
    /// Where any point nearby lies in the tile, voxel units.
    Vec3f tilePosition(const Vec3f& point, const Vec3f& perMm, float mmPerUnit) const;
    /// The normal (unit, object space) of what has the normal `n` in the tile (mm, z outward): the gradient of the same
    /// distance, so that a way in the tile crosses it as it does in the object.
    Vec3f normalOf(const Vec3f& n, float mmPerUnit) const;
};

} // namespace stf
