// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_triangles.h"

#include <functional>
#include <string>
#include <vector>

namespace stf {

/// One object, group or prim of a file, in mm with z up where the file says so, else as given.
struct MeshPart {
    std::string name, path; ///< `path`: of a prim
    std::string material;   ///< name of the material it is bound to; empty: none
    TriangleMesh mesh;
};

/// Reads all meshes of a file. Throws Error with a message that starts with the path.
using MeshReader = std::function<std::vector<MeshPart>(const std::string& path)>;

/// OBJ, PLY, STL and OFF. Polygons are triangulated, points and lines left out. Throws Error for other endings, for
/// what is missing, damaged or larger than `maxBytes`.
std::vector<MeshPart> readMeshFile(const std::string& path, double maxBytes = 2e9);

/// Whether the ending is that of a USD file.
bool isUsdPath(const std::string& path);

} // namespace stf
