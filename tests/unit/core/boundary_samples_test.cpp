// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/boundary_samples.h"

#include "stfLib/core/local_thickness.h"
#include "stfLib/core/sample_filter.h"
#include "tests/unit/core/core_shapes.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

SurfacePoints pointsOf(const CoreShape& s) {
    SurfacePoints p;
    p.areas = s.samples.areas(s.points, s.triangles);
    for (const TrianglePlace& at : s.samples.places) {
        p.positions.push_back(pointAt(s.points, s.triangles[at.triangle], at));
        p.normals.push_back(normalize(pointAt(s.normals, s.triangles[at.triangle], at)));
    }
    return p;
}

TEST(BoundarySamples, AreApartAndCoverTheSurface) {
    const CoreShape s = ball(5, 2000);
    const SurfacePoints p = pointsOf(s);
    EXPECT_NEAR(double(p.areas.size()), 2000, 200);
    const double area = surfaceArea(s.points, s.triangles), radius = std::sqrt(0.6 * area / 2000);
    double sum = 0, least = 1e30, most = 0;
    for (std::size_t i = 0; i < p.areas.size(); ++i) {
        sum += double(p.areas[i]);
        double nearest = 1e30;
        for (std::size_t j = 0; j < p.areas.size(); ++j) {
            nearest = i == j ? nearest : std::min(nearest, double(length(p.positions[i] - p.positions[j])));
        }
        least = std::min(least, nearest);
        most = std::max(most, nearest);
    }
    EXPECT_NEAR(sum / area, 1, 1e-5);
    EXPECT_GE(least, radius * 0.999);
    EXPECT_LE(most, radius * 2) << "no holes";
}

TEST(BoundarySamples, SidesOfAThinSheetDoNotSeeEachOther) {
    const CoreShape s = box({20, 20, 0.01f}, 1000);
    std::size_t above = 0, below = 0;
    for (const Vec3f& p : pointsOf(s).positions) {
        (p.z > 0 ? above : below)++;
    }
    EXPECT_NEAR(double(above), 500, 60);
    EXPECT_NEAR(double(below), 500, 60);
}

TEST(BoundarySamples, RideAlongWhenPointsMove) {
    const CoreShape s = box({2, 2, 2}, 300);
    std::vector<Vec3f> moved = s.points;
    for (Vec3f& p : moved) {
        p.z *= 3; // four of six faces three times as large
    }
    const std::vector<float> before = s.samples.areas(s.points, s.triangles),
                             after = s.samples.areas(moved, s.triangles);
    double sum = 0;
    for (std::size_t i = 0; i < after.size(); ++i) {
        sum += double(after[i]);
        const Vec3f p = pointAt(s.points, s.triangles[s.samples.places[i].triangle], s.samples.places[i]);
        if (std::abs(p.z) > 0.999f) {
            EXPECT_LT(after[i], 2.5f * before[i]);
        }
    }
    EXPECT_NEAR(sum, 2 * 4 + 4 * 12, 1e-3);
}

TEST(BoundarySamples, DeterministicAndNoneOfNothing) {
    const CoreShape a = ball(1, 100), b = ball(1, 100);
    ASSERT_EQ(a.samples.count(), b.samples.count());
    for (std::size_t i = 0; i < a.samples.count(); ++i) {
        EXPECT_EQ(a.samples.places[i].triangle, b.samples.places[i].triangle);
    }
    EXPECT_EQ(spreadSamples({}, {}, 100, 0).count(), 0u);
    EXPECT_EQ(spreadSamples({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}, 100, 0).count(), 0u);
}

TEST(LocalThickness, PlateBallAndHole) {
    const CoreShape plate = box({50, 50, 3}), round = ball(5);
    EXPECT_NEAR(localThickness(*plate.mesh, {1, 2, 1.5f}, {0, 0, -1}), 3, 1e-3);
    // The ray at 60 degrees: 2 r cos 60.
    EXPECT_NEAR(localThickness(*round.mesh, round.points[2000], -normalize(round.points[2000])), 5, 0.1);
    // Half a unit from a sharp edge.
    EXPECT_LT(localThickness(*box(Vec3f(20)).mesh, {9.5f, 0, 10}, {0, 0, -1}), 1.2f);
    CoreShape open;
    open.points = {{-5, -5, 0}, {5, -5, 0}, {0, 5, 0}};
    open.triangles = {{0, 1, 2}};
    open.finish(0);
    EXPECT_TRUE(std::isinf(localThickness(*open.mesh, {0, 0, 0}, {0, 0, -1})));
}

TEST(SampleFilter, KeepsConstantsAndFollowsSmoothValues) {
    const CoreShape s = ball(5, 3000);
    const SurfacePoints p = pointsOf(s);
    std::vector<Rgb> values;
    for (const Vec3f& at : p.positions) {
        values.push_back({1, 2 + at.z / 5, at.x * at.y / 25});
    }
    const float spacing = std::sqrt(4 * 3.14159265f * 25 / 3000);
    const SampleFilter filter(p, s.points, s.normals, {1.8f * spacing});
    const std::vector<Rgb> told = filter.apply(values);
    ASSERT_EQ(told.size(), s.points.size());
    for (std::size_t i = 0; i < told.size(); ++i) {
        EXPECT_NEAR(told[i].x, 1, 1e-5);
        EXPECT_NEAR(told[i].y, 2 + s.points[i].z / 5, 0.02);
        EXPECT_NEAR(told[i].z, s.points[i].x * s.points[i].y / 25, 0.025);
    }
}

TEST(SampleFilter, FarFromAnySampleTheNearestCounts) {
    SurfacePoints p;
    p.positions = {{0, 0, 0}, {10, 0, 0}};
    p.normals = {{0, 0, 1}, {0, 0, 1}};
    p.areas = {1, 1};
    const SampleFilter filter(p, {{7, 0, 0}, {-500, 0, 0}}, {{0, 0, 1}, {0, 0, -1}}, {0.1f});
    const std::vector<Rgb> told = filter.apply({Rgb(1.0f), Rgb(2.0f)});
    EXPECT_EQ(told[0], Rgb(2.0f));
    EXPECT_EQ(told[1], Rgb(1.0f));
}

} // namespace
