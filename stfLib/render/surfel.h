// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/core/boundary_samples.h"
#include "stfLib/render/prepared_scene.h"

namespace stf {

/// A point of a surface that a ray met.
struct Surfel {
    Vec3f point, normal; ///< world; normal of the smooth surface, turned to no side
    Vec3f objectPoint;   ///< on the triangle: exact however far the camera is
    Vec3f shadowOrigin;  ///< object space, lifted to the smooth surface
    Rgb albedo;          ///< displayColor
    std::uint32_t triangle;
    float u, v; ///< on the triangle, as in RayHit
};

Surfel surfelAt(const PreparedInstance& instance, const Ray& ray, const RayHit& hit);

/// A place of a surface as if a ray had met it; `t` is 0.
RayHit hitAt(const PreparedInstance& instance, const TrianglePlace& place);

/// What leaves a shell at a place of its surface, as far as it is kept; black where it is not.
Rgb exitantAt(const PreparedInstance& instance, std::uint32_t triangle, float u, float v);

/// Texture coordinates; (0, 0) on a mesh without.
Vec2f uvAt(const RefinedSurface& surface, const RayHit& hit);

/// Tangent along which u grows, object space, not normalised; zero where there is none.
Vec3f uvTangent(const RefinedSurface& surface, std::uint32_t triangle, bool& mirrored);

} // namespace stf
