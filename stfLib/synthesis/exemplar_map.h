// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/surface/refined_surface.h"

namespace stf {

/// Grows with every change of the algorithm that gives another map for the same input: what was kept is made again.
constexpr int kSynthesisVersion = 2;

/// Where each corner of each triangle of a surface lies in the exemplar: coordinates in tile millimetres, any
/// representative modulo the tile, continuous within a triangle; and the gradients of both coordinates over the
/// surface, from which frames and stretch follow.
struct ExemplarMap {
    std::vector<Vec2f> cornerCoords; ///< 3 per triangle, mm
    /// Surface gradients of the two coordinates, per corner (3 per triangle), mm per object unit, tangent to the
    /// surface; smooth (averaged over the triangles that share the uv vertex), not unit: their length is the stretch.
    std::vector<Vec3f> gradientX;
    std::vector<Vec3f> gradientY;
    Vec2d tileMm;            ///< period of the tile
    std::string description; ///< which mapping was used and why, for the plan
};

/// Plain tiling by the mesh's texture coordinates (DESIGN 3.13). uv are scaled so that on average one tile millimetre
/// is `unitsPerMm` object units along both axes; where uv spans whole numbers (a closed turn), the scale of that axis
/// is rounded so that a whole number of tiles fits and no seam appears. Without uv a planar fallback per dominant axis
/// is NOT made: throws Error("... has no texture coordinates").
ExemplarMap tileByUv(const RefinedSurface& surface, const Vec2d& tileMm, double unitsPerMm,
                     const MessageSink& messages);

} // namespace stf
