// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/ray_scene.h"

namespace stf {

/// How much core there is below a point of the inner boundary, in units of the mesh: the shortest of eleven rays within
/// 60 degrees of the inward normal. That is the thickness of a plate, the radius of curvature of a ball, the distance
/// to a sharp edge. Infinite where every ray leaves through a hole.
float localThickness(const RayMesh& mesh, const Vec3f& point, const Vec3f& inward);

} // namespace stf
