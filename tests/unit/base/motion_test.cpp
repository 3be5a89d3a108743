// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stf::test {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

Transform turned(double degrees, double scale = 1, const Vec3d& translation = Vec3d(0.0)) {
    const double c = std::cos(degrees * kDegree) * scale, s = std::sin(degrees * kDegree) * scale;
    return {{c, s, 0}, {-s, c, 0}, {0, 0, scale}, translation};
}

void expectNear(const Transform& a, const Transform& b, double tolerance) {
    EXPECT_LT(length(a.x - b.x), tolerance);
    EXPECT_LT(length(a.y - b.y), tolerance);
    EXPECT_LT(length(a.z - b.z), tolerance);
    EXPECT_LT(length(a.translation - b.translation), tolerance);
}

TEST(Motion, WhatStandsStillHasNoSteps) {
    const Transform a = turned(10), b = turned(20);
    EXPECT_TRUE(motionSteps({}, {-0.5, 0.5}).empty());
    EXPECT_TRUE(motionSteps({{0, a}}, {-0.5, 0.5}).empty());
    EXPECT_TRUE(motionSteps({{-0.5, a}, {0.5, a}}, {-0.5, 0.5}).empty());
    EXPECT_TRUE(motionSteps({{-0.5, a}, {0.5, b}}, {0, 0}).empty());
    EXPECT_TRUE(motionSteps({{-0.5, a}, {0.5, b}}, {0.5, 0.9}).empty()); // stands where it arrived
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(motionSteps({{nan, a}, {nan, b}}, {0, 1}).empty());
}

TEST(Motion, ALineNeedsOneStep) {
    const std::vector<Transform> steps =
        motionSteps({{1, turned(0, 1, {4, 0, 0})}, {0, turned(0, 1, {0, 2, 0})}}, {0.25, 0.75});
    ASSERT_EQ(steps.size(), 2u);
    expectNear(steps[0], turned(0, 1, {1, 1.5, 0}), 1e-12);
    expectNear(atTime(steps, 0.5f), turned(0, 1, {2, 1, 0}), 1e-12);
    expectNear(atTime(steps, 1), turned(0, 1, {3, 0.5, 0}), 1e-12);
}

// Even turning and growing: the closed form at any time, up to the sagitta of a step of five degrees.
TEST(Motion, RotationsTurnEvenly) {
    for (double sign : {1.0, -1.0}) { // of the third axis: also for mirrored maps
        const auto at = [sign](double t) {
            Transform m = turned(30 + 120 * t, 1 + t, {t, 0, 0});
            m.z = m.z * sign;
            return m;
        };
        const std::vector<Transform> steps = motionSteps({{0, at(0)}, {1, at(1)}}, {0, 1});
        EXPECT_EQ(steps.size(), 25u);
        for (float t : {0.0f, 0.013f, 0.3f, 0.51f, 0.99f, 1.0f}) {
            expectNear(atTime(steps, t), at(double(t)), 2 * (1 - std::cos(2.5 * kDegree)) * 1.01 + 1e-3);
        }
        expectNear(atTime(steps, 0.5f), at(0.5), 1e-9); // on a step
    }
}

TEST(Motion, SamplesBetweenOpeningAndClosingCount) {
    const std::vector<Transform> steps =
        motionSteps({{0, turned(0)}, {0.5, turned(0, 1, {1, 0, 0})}, {1, turned(0)}}, {0, 1});
    EXPECT_NEAR(atTime(steps, 0.5f).translation.x, 1, 1e-12);
    EXPECT_NEAR(atTime(steps, 0.25f).translation.x, 0.5, 1e-12);
    EXPECT_NEAR(atTime(steps, 1).translation.x, 0, 1e-12);
}

TEST(Motion, ThroughASingularPlaceIsLinear) {
    const std::vector<Transform> steps = motionSteps({{0, turned(0)}, {1, turned(0, 0)}}, {0, 1});
    ASSERT_FALSE(steps.empty());
    EXPECT_NEAR(atTime(steps, 0.5f).x.x, 0.5, 1e-12);
}

} // namespace
} // namespace stf::test
