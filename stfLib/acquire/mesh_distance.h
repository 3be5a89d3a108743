// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_cover.h"

namespace stf {

/// Signed distance in mm from the middle of each voxel to the triangles of a mesh that repeats with the tile, negative
/// inside. Where the mesh has a hole it is the distance to the level 1/2 of the winding number, to first order. Walls
/// on the sides of a tile that the mesh just spans do not count, nor does what lies at the tile's bottom or below: the
/// neighbour and the core go on there.
std::vector<float> signedDistance(const MeshColumns& mesh, const TileGrid& grid, Progress& progress);

/// The same for the body: a relief (negative below its upper envelope), meshes, or the plane z = 0.
std::vector<float> signedDistance(const CoverBody& body, const TileGrid& grid, Progress& progress);

/// The distances of what is left of a body and objects in ascending priority: solids that protrude are joined, voids
/// with a surface taken away. Exact in sign and, but near the edges where two of them meet, in value.
std::vector<float> signedDistance(const CoverBody& body, const std::vector<CoverObject>& objects,
                                  const std::vector<char>& protrudes, const TileGrid& grid, Progress& progress);

} // namespace stf
