// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/indirect_light.h"

#include "stfLib/render/surface_point.h"

#include <algorithm>

namespace stf {

namespace {

/// Least cosine: what grazes a surface comes from a little higher, since what bends away in a shell would see its
/// perpendicular irradiance, which has no bound. It is a 400th of all light of an even hemisphere.
constexpr float kLowest = 0.05f;
constexpr float kPi = 3.14159265358979f;

} // namespace

void chooseDirections(std::vector<IndirectRay>& rays, const Vec3f& normal, float u, Vec3f* directions) {
    std::sort(rays.begin(), rays.end(), [&](const IndirectRay& a, const IndirectRay& b) {
        return dot(a.towards, normal) > dot(b.towards, normal);
    });
    double all = 0;
    for (const IndirectRay& r : rays) {
        all += double(average(r.radiance));
    }
    constexpr int n = IndirectLight::kDirections;
    if (!(all > 0)) {
        std::fill(directions, directions + n, normal);
        return;
    }
    // Places within the shares by turns u and 1 - u: what changes evenly with height is exact for any u.
    const auto place = [&](int share) { return double(share) + (share % 2 ? 1 - double(u) : double(u)); };
    double upTo = 0;
    int k = 0;
    for (const IndirectRay& r : rays) {
        upTo += double(average(r.radiance));
        for (; k < n && place(k) * all < upTo * n; ++k) {
            directions[k] = r.towards;
        }
    }
    for (; k < n; ++k) { // rounding
        directions[k] = rays.back().towards;
    }
}

IndirectSample sampleIndirect(const IndirectLight& light, const Vec3i& corners, float u, float v, const Vec3f& normal,
                              PixelSampler& sampler) {
    IndirectSample out;
    const Rgb share = betweenCorners(light.mean, corners, u, v) * (kPi / float(IndirectSample::kDirections));
    const Vec2f which = sampler.next2d();
    const float corner = sampler.next1d();
    const int point = corner < u ? corners.y : corner < u + v ? corners.z : corners.x;
    const std::size_t first = std::size_t(light.sample[std::size_t(point)]) * IndirectLight::kDirections;
    constexpr int half = IndirectLight::kDirections / IndirectSample::kDirections;
    const float picks[] = {which.x, which.y};
    for (int k = 0; k < IndirectSample::kDirections; ++k) {
        const int j = k * half + std::min(half - 1, int(picks[k] * float(half)));
        Vec3f d = light.directions[first + std::size_t(j)];
        float cosine = dot(d, normal);
        if (cosine < kLowest) {
            const Vec3f across = d - normal * cosine;
            const float length2 = dot(across, across);
            cosine = length2 > 0 ? kLowest : 1.0f;
            d = length2 > 0 ? across * std::sqrt((1 - kLowest * kLowest) / length2) + normal * kLowest : normal;
        }
        out.towards[k] = d;
        out.irradiance[k] = share / cosine;
    }
    return out;
}

} // namespace stf
