// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/shell/shell_level.h"
#include "stfLib/shell/shell_surface.h"
#include "stfLib/synthesis/exemplar_map.h"

#include <functional>

namespace stf {

/// Voxels beyond both boundaries that have samples: a lookup on a boundary has corners up to a voxel's diagonal off.
constexpr double kShellMargin = 1.8;

/// What a shell is made of.
struct ShellSource {
    const RefinedSurface& surface;
    const ShellBoundary& boundary;
    const ExemplarMap& map;
    double mmPerUnit;
};

/// Everything known below a point of a triangle at a depth (object units).
ShellPoint shellPoint(const ShellSource& source, std::size_t triangle, double b1, double b2, double depth);

struct ScanCounts {
    std::size_t unusableTriangles = 0; ///< without area or with numbers that are none: they have no shell
};

/// Fills a level whose origin, voxel and codec are set, but does not `finish` it. Deterministic for any number of
/// threads. `progress` takes the share done; an exception of it ends the scan.
ScanCounts scanShell(const ShellSource& source, ShellLevel& level, const std::function<void(double)>& progress);

} // namespace stf
