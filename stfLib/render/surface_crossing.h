// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// What a smooth dielectric surface does to a ray: the reflected share and both directions.
struct SurfaceCrossing {
    float reflectance = 0; ///< Fresnel, 0 to 1; 1: nothing crosses and `refracted` means nothing
    Vec3f refracted;       ///< unit, behind the facet
    Vec3f reflected;       ///< unit, in front of the facet
};

/// Crossing of a triangulated smooth surface. `direction` is the unit direction of travel; `normal` the unit normal of
/// the smooth surface and `facet` that of the triangle (any length), both on the side the ray comes from, where the
/// facet faces the ray: dot(direction, facet) < 0. `eta` is the index behind over that in front.
///
/// The smooth normal decides. Where it faces away while the triangle is seen, at silhouettes, the ray counts as
/// grazing; where it would send a ray to the wrong side of the triangle, the triangle's own normal gives the direction.
SurfaceCrossing crossSurface(const Vec3f& direction, const Vec3f& normal, const Vec3f& facet, float eta);

} // namespace stf
