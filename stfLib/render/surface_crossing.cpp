// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/surface_crossing.h"

#include "stfLib/optics/fresnel.h"

namespace stf {

namespace {
/// Cosine that a ray has at least to the normal it is turned by.
constexpr float kGrazing = 0.01f;
} // namespace

SurfaceCrossing crossSurface(const Vec3f& direction, const Vec3f& normal, const Vec3f& facetNormal, float eta) {
    const Vec3f facet = normalize(facetNormal);
    Vec3f n = normal;
    if (!(dot(direction, n) < -kGrazing)) {
        const Vec3f across = n - direction * dot(n, direction);
        n = length(across) > kGrazing ? normalize(normalize(across) - direction * kGrazing) : facet;
    }
    SurfaceCrossing result;
    const FresnelSplit split = fresnel(-dot(direction, n), eta);
    result.reflectance = split.reflectance;
    result.reflected = reflect(direction, n);
    if (!(dot(result.reflected, facet) > 0)) {
        result.reflected = reflect(direction, facet);
    }
    result.refracted = direction;
    if (split.reflectance < 1) {
        result.refracted = refract(direction, n, eta, split);
        if (!(dot(result.refracted, facet) < 0)) {
            const FresnelSplit own = fresnel(-dot(direction, facet), eta);
            result.refracted = own.reflectance < 1 ? refract(direction, facet, eta, own) : direction;
        }
    }
    return result;
}

} // namespace stf
