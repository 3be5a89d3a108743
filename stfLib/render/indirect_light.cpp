// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/indirect_light.h"

#include "stfLib/base/hemisphere.h"

#include <algorithm>

namespace stf {

namespace {

constexpr int kCandidates = 4;
constexpr float kSteepest = 1.5f; ///< slope over mean: from bright to black across the hemisphere
constexpr float kDarkest = 0.05f; ///< of the mean: no direction is wholly left out
/// Least cosine: light that grazes a surface comes from a little higher (one per cent of it), since what bends away in
/// a shell would see its perpendicular irradiance, which has no bound.
constexpr float kLowest = 0.1f;
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
    Vec3f x, y;
    orthonormalBasis(normal, x, y);
    const PixelSampler::Points u = sampler.next2dPoints(kCandidates);
    const float pick = sampler.next1d();
    const float along = dot(light.slope, normal);
    Vec3f directions[kCandidates];
    float cosine[kCandidates], upTo[kCandidates], sum = 0;
    for (int k = 0; k < kCandidates; ++k) {
        Vec3f d = cosineHemisphere(u[k]);
        if (d.z < kLowest) {
            const float r = std::sqrt((1 - kLowest * kLowest) / (1 - d.z * d.z));
            d = {d.x * r, d.y * r, kLowest};
        }
        directions[k] = x * d.x + y * d.y + normal * d.z;
        cosine[k] = d.z;
        sum += std::max(kDarkest, 1 + dot(light.slope, directions[k]) - along * (2.0f / 3)); // E[z] is 2/3
        upTo[k] = sum;
    }
    int k = 0;
    while (k + 1 < kCandidates && upTo[k] <= pick * sum) {
        ++k;
    }
    return {directions[k], light.mean * (kPi / cosine[k])};
}

} // namespace stf
