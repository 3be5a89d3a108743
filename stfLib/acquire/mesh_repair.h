// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_triangles.h"

#include <string>

namespace stf {

/// What `repair` found and did; counts are of triangles unless they say otherwise.
struct MeshRepair {
    std::size_t points = 0, triangles = 0;      ///< as given
    std::size_t degenerate = 0, duplicates = 0; ///< dropped
    std::size_t turned = 0;                     ///< faced inward or against their neighbours
    std::size_t pieces = 0;                     ///< connected surfaces
    std::size_t holes = 0;                      ///< loops of edges with one side only
    double boundaryMm = 0;                      ///< their length, in the units of the mesh
    std::size_t crowdedEdges = 0;               ///< edges of more than two triangles
    double volume = 0;                          ///< enclosed, in units^3; holes closed by fans
    bool sound() const { return degenerate + duplicates + turned + holes + crowdedEdges == 0; }
    /// One sentence without the name of the mesh.
    std::string summary() const;
};

/// A mesh whose triangles face outward, and triangles that close it. Inside is where the generalised winding number of
/// `mesh` is above 1/2: the (whole) winding number of both together less that of `caps`.
struct MendedMesh {
    TriangleMesh mesh;
    TriangleMesh caps; ///< fans over the holes, about the middle of each; empty for a closed mesh
    MeshRepair repair;
};

/// Merges equal points, drops degenerate and repeated triangles, turns triangles to agree with their neighbours and
/// connected pieces outward (a piece inside another one that faces inward is a cavity and stays), and finds the holes.
/// Throws Error with a message that starts with `name`: no triangle, indices out of range, coordinates that are not
/// finite or beyond 1e9 units, with the number of the first.
MendedMesh repair(const TriangleMesh& mesh, const std::string& name);

} // namespace stf
