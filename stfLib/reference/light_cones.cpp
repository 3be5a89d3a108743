// SPDX-License-Identifier: Apache-2.0
#include "stfLib/reference/light_cones.h"

#include "stfLib/optics/fresnel.h"

namespace stf {

namespace {
constexpr float kPi = 3.14159265358979f;
constexpr float kNarrow = 0.02f, kWide = 0.2f; // radians beside the light's own half angle
} // namespace

void LightCones::add(const Vec3f& towards, const Vec3f& normal, float ior, float cosHalf) {
    const float cosine = dot(towards, normal);
    if (!(cosine > 0) || count_ + 2 > kMost) {
        return;
    }
    const FresnelSplit split = fresnel(cosine, ior);
    if (!(split.reflectance < 1)) {
        return;
    }
    const Vec3f axis = -refract(-towards, normal, ior, split);
    const float half = std::acos(std::clamp(cosHalf, -1.0f, 1.0f));
    for (const float beside : {kNarrow, kWide}) {
        cones_[std::size_t(count_++)] = {axis, std::cos(std::min(half + beside, kPi))};
    }
}

Vec3f LightCones::sample(float pick, float u1, float u2) const {
    const Cone& c = cones_[std::size_t(std::min(count_ - 1, int(pick * float(count_))))];
    Vec3f x, y;
    orthonormalBasis(c.axis, x, y);
    const float versine = u1 * (1 - c.cosHalf), cosine = 1 - versine; // 1 - cos keeps its digits for narrow cones
    const float sine = std::sqrt(std::max(0.0f, versine * (2 - versine))), phi = 2 * kPi * u2;
    return normalize(x * (sine * std::cos(phi)) + y * (sine * std::sin(phi)) + c.axis * cosine);
}

float LightCones::density(const Vec3f& towards) const {
    float sum = 0;
    for (int i = 0; i < count_; ++i) {
        const Cone& c = cones_[std::size_t(i)];
        sum += dot(towards, c.axis) >= c.cosHalf ? 1 / (2 * kPi * (1 - c.cosHalf)) : 0.0f;
    }
    return count_ > 0 ? sum / float(count_) : 0.0f;
}

} // namespace stf
