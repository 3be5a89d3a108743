// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/ray_scene.h"
#include "stfLib/surface/refined_surface.h"

#include <vector>

namespace stf {

/// A value per point of a surface, between the corners of a triangle; u, v as in RayHit.
template<class T>
T betweenCorners(const std::vector<T>& values, const Vec3i& corners, float u, float v) {
    return values[std::size_t(corners.x)] * (1 - u - v) + values[std::size_t(corners.y)] * u +
           values[std::size_t(corners.z)] * v;
}

/// Normal of the smooth surface, object space, not normalised.
inline Vec3f smoothNormal(const RefinedSurface& s, const RayHit& hit) {
    if (!s.cornerNormals.empty()) {
        const int c = int(3 * hit.triangle);
        return betweenCorners(s.cornerNormals, {c, c + 1, c + 2}, hit.u, hit.v);
    }
    if (!s.faceNormals.empty()) {
        return s.faceNormals[std::size_t(s.triangleFace[hit.triangle])];
    }
    return betweenCorners(s.normals, s.triangles[hit.triangle], hit.u, hit.v);
}

} // namespace stf
