// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/transform.h"

#include <gtest/gtest.h>
#include <limits>

using namespace stf;

namespace {

// Rotated, sheared, scaled unevenly and far from the origin.
Transform general() {
    Transform t;
    t.x = {1.5, 0.25, -0.5};
    t.y = {-0.75, 3, 0.125};
    t.z = {0.5, -0.25, 0.1};
    t.translation = {1e3, -20, 7};
    return t;
}

Transform mirrored() {
    Transform t = general();
    t.x = -t.x;
    return t;
}

void expectNear(const Vec3d& a, const Vec3d& b, double eps) {
    EXPECT_NEAR(length(a - b), 0, eps);
}

TEST(Transform, InverseUndoes) {
    for (const Transform& t : {general(), mirrored()}) {
        ASSERT_TRUE(t.invertible());
        const Vec3d p(3, -4, 5);
        expectNear(t.inverse().point(t.point(p)), p, 1e-11);
        expectNear(t.point(t.inverse().point(p)), p, 1e-11);
        expectNear(t.inverse().vector(t.vector(p)), p, 1e-11);
        expectNear(t.inverse().inverse().point(p), t.point(p), 1e-11);
    }
}

TEST(Transform, NormalStaysPerpendicularAndOutward) {
    for (const Transform& t : {general(), mirrored()}) {
        const Vec3d a(1, 2, 0.5), b(-0.25, 1, 3), n = cross(a, b);
        EXPECT_NEAR(dot(t.normal(n), t.vector(a)), 0, 1e-12);
        EXPECT_NEAR(dot(t.normal(n), t.vector(b)), 0, 1e-12);
        // A point outside stays outside, mirrored or not.
        EXPECT_GT(dot(t.normal(n), t.vector(n)), 0);
    }
}

TEST(Transform, MirrorHasNegativeDeterminant) {
    EXPECT_NEAR(mirrored().determinant(), -general().determinant(), 1e-12);
    EXPECT_GT(general().determinant(), 0);
}

TEST(Transform, ComposeAppliesTheSecondArgumentFirst) {
    const Transform a = general(), b = mirrored();
    const Vec3d p(0.1, 0.2, 0.3);
    expectNear(compose(b, a).point(p), b.point(a.point(p)), 1e-11);
    expectNear(compose(a.inverse(), a).point(p), p, 1e-11);
}

TEST(Transform, RowMajorHasTheTranslationInItsLastRow) {
    const double m[16] = {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 10, 0, 11, 12, 13, 1};
    const Transform t = Transform::fromRowMajor(m);
    EXPECT_EQ(t.point({1, 0, 0}), Vec3d(12, 14, 16));
    EXPECT_EQ(t.point({0, 0, 1}), Vec3d(18, 20, 23));
}

TEST(Transform, ScaleIsNoSingularity) {
    for (double s : {1e-9, 1.0, 1e9}) {
        Transform t = general();
        t.x *= s, t.y *= s, t.z *= s, t.translation *= s;
        EXPECT_TRUE(t.invertible()) << s;
        expectNear(t.inverse().point(t.point({1, 2, 3})), {1, 2, 3}, 1e-11);
    }
}

TEST(Transform, SingularOrNotFinite) {
    Transform flat = general();
    flat.z = {0, 0, 0};
    EXPECT_FALSE(flat.invertible());
    Transform dependent = general();
    dependent.z = dependent.x * 2.0 + dependent.y;
    EXPECT_FALSE(dependent.invertible());
    Transform nan = general();
    nan.y.x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(nan.invertible());
    Transform infinite = general();
    infinite.translation.z = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(infinite.invertible());
    EXPECT_TRUE(Transform().invertible());
}

} // namespace
