// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/phase.h"

namespace stf {

namespace {
constexpr float kPi = 3.14159265358979f;
}

float henyeyGreenstein(float g, const Vec3f& from, const Vec3f& to) {
    const float a = std::abs(g);
    const Vec3f d = g >= 0 ? to - from : to + from;
    const float q = (1 - a) * (1 - a) + a * dot(d, d); // 2 |g| (1 - cos) = |g| |d|^2
    return (1 - a) * (1 + a) / (4 * kPi * q * std::sqrt(q));
}

Vec3f sampleHenyeyGreenstein(float g, const Vec3f& from, float u1, float u2) {
    const float a = std::abs(g), m = 1 - a, d = m + 2 * a * u1;
    const float oneMinusCos = 2 * (m / d) * (m / d) * (1 - u1) * (1 + a * u1);
    const float onePlusCos = 2 * ((1 + a) / d) * ((1 + a) / d) * u1 * (m + a * u1);
    const float sinTheta = std::sqrt(std::max(0.0f, oneMinusCos * onePlusCos));
    // The smaller of the two carries the precision.
    float cosTheta = oneMinusCos < 1 ? 1 - oneMinusCos : onePlusCos - 1;
    if (g < 0) {
        cosTheta = -cosTheta;
    }
    const float phi = 2 * kPi * u2;
    Vec3f t, b;
    orthonormalBasis(from, t, b);
    return normalize(t * (sinTheta * std::cos(phi)) + b * (sinTheta * std::sin(phi)) + from * cosTheta);
}

} // namespace stf
