// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/indirect_light.h"

#include <algorithm>

namespace stf {

namespace {

constexpr float kSteepest = 1.5f; ///< slope over mean: from bright to black across the hemisphere
constexpr float kDarkest = 0.05f; ///< of the mean: no direction is wholly left out
constexpr float kPi = 3.14159265358979f;

} // namespace

// Under a density of cosine / pi: E[z] = 2/3, Var[z] = 1/18, E[x^2] = 1/4, and x, y, z are not correlated.
IndirectLight IndirectSum::light(int rays, const Vec3f& normal) const {
    const float inverse = 1 / float(rays);
    const Rgb mean = radiance_ * inverse;
    const Vec3f moment = moment_ * inverse;
    const float along = dot(moment, normal);
    const Vec3f across = moment - normal * along;
    return {mean, across * 4.0f + normal * (18 * (along - average(mean) * (2.0f / 3)))};
}

IndirectLight relative(const IndirectLight& absolute) {
    const float mean = average(absolute.mean);
    if (!(mean > 0)) {
        return {};
    }
    const Vec3f slope = absolute.slope / mean;
    const float steep = length(slope);
    return {absolute.mean, steep > kSteepest ? slope * (kSteepest / steep) : slope};
}

IndirectSample sampleIndirect(const IndirectLight& light, const Vec3f& normal, PixelSampler& sampler) {
    static const float nodes[IndirectSample::kDirections] = {std::sqrt(0.5f + std::sqrt(1.0f / 12)),
                                                             std::sqrt(0.5f - std::sqrt(1.0f / 12))};
    const float middle = 0.5f * (nodes[0] + nodes[1]); // E[z] by the rule; it is 2/3
    Vec3f x, y;
    orthonormalBasis(normal, x, y);
    const Vec2f u = sampler.next2d(), v = sampler.next2d();
    const float turn[] = {u.x, u.y}, pick[] = {v.x, v.y};
    const float along = dot(light.slope, normal);
    float bright[IndirectSample::kDirections], sum = 0;
    for (int k = 0; k < IndirectSample::kDirections; ++k) {
        bright[k] = std::max(kDarkest, 1 + along * (nodes[k] - middle));
        sum += bright[k];
    }
    IndirectSample out;
    for (int k = 0; k < IndirectSample::kDirections; ++k) {
        const float cosine = nodes[k], sine = std::sqrt(1 - cosine * cosine), phi = 2 * kPi * turn[k];
        Vec3f across = (x * std::cos(phi) + y * std::sin(phi)) * sine;
        // One of two opposite sides: both together are as bright as the mean.
        const float tilt = std::clamp(dot(light.slope, across) / bright[k], kDarkest - 1, 1 - kDarkest);
        across = pick[k] < 0.5f * (1 + tilt) ? across : -across;
        out.towards[k] = across + normal * cosine;
        out.irradiance[k] = light.mean * (kPi * bright[k] / (sum * cosine));
    }
    return out;
}

} // namespace stf
