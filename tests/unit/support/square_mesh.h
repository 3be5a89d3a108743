// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/control_mesh.h"

namespace stf::test {

/// A square about a point with half its edges as vectors; its front is on the side of their cross product.
inline ControlMesh squareMesh(const Vec3f& middle, const Vec3f& x, const Vec3f& y) {
    ControlMesh m;
    m.scheme = ControlMesh::Scheme::None;
    m.points = {middle - x - y, middle + x - y, middle + x + y, middle - x + y};
    m.faceVertexCounts = {4};
    m.faceVertexIndices = {0, 1, 2, 3};
    m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    m.uvIndices = {0, 1, 2, 3};
    return m;
}

} // namespace stf::test
