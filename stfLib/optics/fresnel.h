// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// What a smooth dielectric boundary does to unpolarised light. The share that enters is 1 - reflectance.
template<class T>
struct FresnelSplitOf {
    T reflectance; ///< 0 to 1; 1 where reflection is total
    T cosT;        ///< cosine of the refracted direction to the normal, 0 to 1; 0 where reflection is total
};
using FresnelSplit = FresnelSplitOf<float>;

/// Fresnel's equations for unpolarised light that arrives at cosine `cosI` >= 0 to the normal (a negative one counts
/// as 0); `eta` = n_t / n_i > 0, the index of the side it enters over that of the side it comes from.
///
/// The form of Cook & Torrance 1982 ("A Reflectance Model for Computer Graphics", g^2 = eta^2 - 1 + c^2), written
/// without cancellation: no digit is lost as eta goes to 1, where (g - c) / (g + c) would keep none. eta = 1 gives 0 at
/// every angle, also at 90 degrees. Relative error of the reflectance below 1e-6 in float32 (tests/unit/optics).
template<class T>
inline FresnelSplitOf<T> fresnelSplit(T cosI, T eta) {
    if (eta == T(1)) {
        return {T(0), std::min(std::max(cosI, T(0)), T(1))};
    }
    if (!(cosI > T(0))) {
        return {T(1), eta > T(1) ? T(std::sqrt((double(eta) - 1) * (double(eta) + 1)) / double(eta)) : T(0)};
    }
    const T c = std::min(cosI, T(1));
    // The one difference of like numbers, at the edge of total reflection, is taken in double: exact for float32.
    const double wide = (double(eta) - 1) * (double(eta) + 1), square = wide + double(c) * double(c);
    if (square <= 0) {
        return {T(1), T(0)};
    }
    const T k = T(wide), g = T(std::sqrt(square));
    const T a = k / ((c + g) * (c + g)), q = (c * (g + c) - T(1)) / (c * (g - c) + T(1));
    return {std::min(T(0.5) * a * a * (T(1) + q * q), T(1)), std::min(g / eta, T(1))};
}

inline FresnelSplit fresnel(float cosI, float eta) {
    return fresnelSplit<float>(cosI, eta);
}
/// The reflectance alone.
inline float fresnelReflectance(float cosI, float eta) {
    return fresnelSplit<float>(cosI, eta).reflectance;
}

/// Unit direction of travel behind the boundary, by Snell's law. `normal` is the unit normal on the side the light
/// comes from (dot(direction, normal) <= 0) and `split` = fresnel(-dot(direction, normal), eta). Meaningless where the
/// reflection is total.
inline Vec3f refract(const Vec3f& direction, const Vec3f& normal, float eta, const FresnelSplit& split) {
    const Vec3f tangential = direction - normal * dot(direction, normal);
    return normalize(tangential / eta - normal * split.cosT);
}

/// Unit direction of travel after mirror reflection; `normal` may have either sign.
inline Vec3f reflect(const Vec3f& direction, const Vec3f& normal) {
    return normalize(direction - normal * (2 * dot(direction, normal)));
}

/// Reflectance for diffuse (Lambertian) light, 2 INT R(mu) mu dmu: F_ext for eta > 1, F_int for eta < 1 (with
/// eta = n_t / n_i as above), 0 at eta = 1. Relative error below 1e-12; not for inner loops.
/// F_int = 1 - (1 - F_ext) / n^2 with n = 1 / eta, the balance of a furnace of both sides.
double diffuseFresnel(double eta);

} // namespace stf
