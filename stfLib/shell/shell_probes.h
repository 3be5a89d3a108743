// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/shell/shell_edges.h"
#include "stfLib/shell/shell_scan.h"

#include <cstdint>

namespace stf {

/// A random point of a shell and the exact answer there: that of the prism whose surface is nearest.
struct ShellProbe {
    Vec3d point;         ///< object space
    Vec3d foot;          ///< on the surface, above the point
    ShellPoint exact;    ///< by inversion of the prism
    double seamDistance; ///< of the foot, object units; the search distance where no seam is nearer
};

/// About `count` points, evenly over the shell's volume, with their exact answers; seams are looked for within
/// `seamReach` (object units). The same for any number of threads.
std::vector<ShellProbe> makeProbes(const ShellSource& source, const ShellEdges& edges, std::size_t count,
                                   double seamReach);

} // namespace stf
