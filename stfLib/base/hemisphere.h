// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// Unit direction about +z, density cosine / pi; `u` in [0, 1)^2.
inline Vec3f cosineHemisphere(Vec2f u) {
    const float r = std::sqrt(u.x), phi = 6.28318530717959f * u.y;
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(std::max(0.0f, 1 - u.x))};
}

/// Of directions for a surface that light may meet at depths where it faces another way: mostly by the cosine, and a
/// uniform part that bounds radiance over density.
constexpr float kUniformPart = 0.25f;

/// Unit direction about +z of that mixture; `u` in [0, 1)^2.
inline Vec3f mixedHemisphere(Vec2f u) {
    constexpr float cosinePart = 1 - kUniformPart;
    if (u.x < cosinePart) {
        return cosineHemisphere({u.x / cosinePart, u.y});
    }
    const float z = std::max(0.0f, 1 - (u.x - cosinePart) / kUniformPart);
    const float r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 6.28318530717959f * u.y;
    return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Its density per solid angle, by the cosine to the normal.
inline float mixedHemisphereDensity(float cosine) {
    constexpr float pi = 3.14159265358979f;
    return cosine > 0 ? (1 - kUniformPart) * cosine / pi + kUniformPart / (2 * pi) : 0.0f;
}

} // namespace stf
