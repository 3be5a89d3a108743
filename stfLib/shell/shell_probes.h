// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/shell/shell_edges.h"
#include "stfLib/shell/shell_scan.h"

#include <cstdint>

namespace stf {

/// A random point of a shell and the exact answer there: that of the prism whose surface is nearest.
struct ProbedPoint {
    Vec3d point;         ///< object space
    ShellPoint exact;    ///< by inversion of the prism
    double seamDistance; ///< from the wall below the nearest seam, object units; at most the search distance
};

/// About `count` points, evenly over the shell's volume, with their exact answers; seams are looked for within
/// `seamReach` (object units). The same for any number of threads.
std::vector<ProbedPoint> makeProbes(const ShellSource& source, const ShellEdges& edges, std::size_t count,
                                   double seamReach);

} // namespace stf
