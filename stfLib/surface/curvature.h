// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/surface_graph.h"

#include <vector>

namespace stf {

/// Principal curvatures at a vertex, 1 / object unit: positive where the surface bends away from its outward normal, as
/// a sphere does, so that a shell inward of it gets narrower with depth and folds over at 1 / k1.
struct Curvature {
    float k1 = 0, k2 = 0; ///< k1 >= k2
    Vec3f direction1;     ///< unit tangent along which the normal turns by k1
};

/// Least-squares shape operator from the normals of each vertex and its neighbours.
std::vector<Curvature> curvatures(const SurfaceGraph& graph);

} // namespace stf
