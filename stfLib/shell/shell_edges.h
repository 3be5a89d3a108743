// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/synthesis/exemplar_map.h"

namespace stf {

/// Edges of a surface that matter to a shell.
struct ShellEdges {
    /// Points of the surface at the ends of edges where the exemplar's coordinates or the shading normals jump.
    std::vector<std::pair<int, int>> seams;
    double seamLength = 0; ///< object units
    std::size_t rims = 0;  ///< edges of one triangle: the shell ends there in a wall
    double rimLength = 0;
    std::size_t crowded = 0; ///< edges of more than two triangles
    std::size_t turned = 0;  ///< edges whose two triangles run the same way: one of them is inside out
};

/// Edges by the positions of their ends, since a vertex may be there once for each smooth side. Triangles without area
/// are left out.
ShellEdges findEdges(const RefinedSurface& surface, const ExemplarMap& map);

} // namespace stf
