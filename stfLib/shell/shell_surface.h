// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/surface/refined_surface.h"

namespace stf {

/// Why a shell is thinner than wanted: shares of the surface's area, each point counted for what bound it most.
struct ShellClamping {
    double curvature = 0; ///< it would fold over
    double thinParts = 0; ///< it would meet the shell of the other side
    double turned = 0;    ///< triangles turned over because their corners differ in thickness
    double beside = 0;    ///< a neighbour is thinner, and thickness changes gradually
    float lowest = 0;     ///< object units
    double total() const { return curvature + thinParts + turned + beside; }
};

/// The shell's inner boundary: the limit surface moved inward along its normals, at hard edges by as much more as keeps
/// the boundary parallel to the faces (mitred).
struct ShellBoundary {
    std::vector<Vec3f> inner;     ///< one per point of the surface, object space
    std::vector<float> thickness; ///< object units, across the shell, per point; at most the wanted one
    int clampedPoints = 0;        ///< points where it was lowered
    ShellClamping clamping;
};

/// Offsets by `thickness` (object units). Where the offset would fold over (thickness above 0.9 of the concave-side
/// radius of curvature) or meet the shell of the other side (above 0.45 of the local thickness, by inward rays), it is
/// lowered, and the lowering is spread smoothly to the neighbours. Reports how much of the surface was, and why.
ShellBoundary offsetInward(const RefinedSurface& surface, float thickness, const MessageSink& messages);

} // namespace stf
