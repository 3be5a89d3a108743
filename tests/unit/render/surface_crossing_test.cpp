// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/surface_crossing.h"

#include "stfLib/base/random.h"
#include "stfLib/optics/fresnel.h"

#include <gtest/gtest.h>

namespace stf::test {
namespace {

// Uniform over the sphere.
Vec3f direction(CounterRng& rng) {
    const float z = 2 * rng.uniform() - 1, r = std::sqrt(1 - z * z), phi = 6.2831853f * rng.uniform();
    return {r * std::cos(phi), r * std::sin(phi), z};
}

TEST(SurfaceCrossing, SnellFresnelAndMirror) {
    const Vec3f up(0, 0, 1);
    for (const float eta : {0.75f, 1.3f, 1.5f}) {
        for (const float angle : {0.0f, 0.3f, 0.8f}) {
            const Vec3f d(std::sin(angle), 0, -std::cos(angle));
            const SurfaceCrossing c = crossSurface(d, up, up, eta);
            EXPECT_FLOAT_EQ(c.reflectance, fresnelReflectance(std::cos(angle), eta));
            EXPECT_NEAR(c.reflected.x, d.x, 1e-6f);
            EXPECT_NEAR(c.reflected.z, -d.z, 1e-6f);
            EXPECT_NEAR(c.refracted.x * eta, d.x, 1e-6f);
            EXPECT_LT(c.refracted.z, 0);
        }
    }
}

TEST(SurfaceCrossing, IndexOneChangesNothing) {
    const Vec3f d = normalize(Vec3f(1, 2, -3));
    const SurfaceCrossing c = crossSurface(d, normalize(Vec3f(0.2f, 0, 1)), {0, 0, 1}, 1);
    EXPECT_EQ(c.reflectance, 0);
    EXPECT_LT(length(c.refracted - d), 1e-6f);
}

TEST(SurfaceCrossing, TotalReflection) {
    const Vec3f d = normalize(Vec3f(1, 0, -1)); // beyond the critical angle of 1.5, 41.8 degrees
    const SurfaceCrossing c = crossSurface(d, {0, 0, 1}, {0, 0, 1}, 1 / 1.5f);
    EXPECT_EQ(c.reflectance, 1);
    EXPECT_GT(c.reflected.z, 0);
}

// There and back through the same surface: the same share, the same way.
TEST(SurfaceCrossing, Reciprocity) {
    const Vec3f up(0, 0, 1), d = normalize(Vec3f(1, 0.5f, -1));
    const SurfaceCrossing in = crossSurface(d, up, up, 1.5f);
    const SurfaceCrossing out = crossSurface(-in.refracted, -up, -up, 1 / 1.5f);
    EXPECT_NEAR(in.reflectance, out.reflectance, 1e-6f);
    EXPECT_LT(length(out.refracted + d), 1e-6f);
}

// Whatever the smooth normal is, rays stay on their side of the triangle.
TEST(SurfaceCrossing, AnyNormalsGiveUsableRays) {
    CounterRng rng(1, 2);
    for (int i = 0; i < 100000; ++i) {
        const Vec3f facet = direction(rng) * (0.1f + rng.uniform()), d = direction(rng), n = direction(rng);
        if (!(dot(d, facet) < -1e-4f)) {
            continue;
        }
        for (const float eta : {0.6f, 1.0f, 1.0001f, 1.5f, 2.4f}) {
            const SurfaceCrossing c = crossSurface(d, n, facet, eta);
            ASSERT_GE(c.reflectance, 0);
            ASSERT_LE(c.reflectance, 1);
            ASSERT_NEAR(length(c.reflected), 1, 1e-5f);
            ASSERT_GT(dot(c.reflected, facet), 0);
            if (c.reflectance < 1) {
                ASSERT_NEAR(length(c.refracted), 1, 1e-5f);
                ASSERT_LT(dot(c.refracted, facet), 0);
            }
        }
    }
}

} // namespace
} // namespace stf::test
