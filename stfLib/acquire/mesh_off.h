// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_triangles.h"

#include <string>

namespace stf {

/// Reads an OFF file in text (Geomview; also with normals, colours or texture coordinates, which are passed over);
/// polygons become triangles. Throws Error with the path and the element: another kind of file, cut off, counts that the
/// file cannot hold, faces of vertices that are not there.
TriangleMesh readOff(const std::string& path);

} // namespace stf
