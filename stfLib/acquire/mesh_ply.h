// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_triangles.h"

#include <string>

namespace stf {

/// Reads the vertices and faces of a PLY file (Turk 1994; text, binary of either byte order); polygons become triangles,
/// other elements and properties are passed over. Throws Error with the path and the element: not PLY, cut off, counts
/// that the file cannot hold, faces of vertices that are not there.
TriangleMesh readPly(const std::string& path);

} // namespace stf
