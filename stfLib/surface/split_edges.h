// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/refined_surface.h"

namespace stf {

/// The same surface with no edge longer than `maxEdge` (object units): longest-edge bisection (Rivara 1984, "Algorithms
/// for refining triangular grids suitable for adaptive and multigrid techniques"), which keeps triangles as well shaped
/// as they were. New points lie on the cubic through both ends and their normals (Vlachos et al. 2001, "Curved PN
/// Triangles"), so that a coarse limit surface stays round; on facets they lie in the facet. Texture coordinates,
/// colours, tangents, faces and corner normals follow, and so does a `pose` of the surface, by the same rules: where it
/// is split is decided on the surface alone. Edges that are shorter already stay. Stops, with a message, before there
/// would be more than `maxTriangles`. Throws Error for an edge that is not positive.
RefinedSurface splitLongEdges(RefinedSurface surface, double maxEdge, std::size_t maxTriangles,
                              const MessageSink& messages, SurfacePose* pose = nullptr);

} // namespace stf
