// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/point_set.h"

#include "tests/unit/surface/tessellation_measures.h"

#include <gtest/gtest.h>
#include <limits>

using namespace stf;
using namespace stf::test;

namespace {

constexpr std::size_t plenty = 10'000'000;

PointSet row(std::size_t count) {
    PointSet set;
    for (std::size_t i = 0; i < count; ++i) {
        set.points.push_back({float(4 * i), 0, 0});
    }
    return set;
}

} // namespace

TEST(PointSet, SpheresAreClosedAndHaveTheirArea) {
    for (const auto& [most, triangles] : {std::pair(plenty, 1280), {1000, 320}, {200, 80}, {79, 20}, {19, 8}}) {
        PointSet set = row(1);
        set.points[0] = {1, 2, 3};
        set.widths = {3};
        PointRepairs repairs;
        const ControlMesh mesh = tessellate(set, 2, most, repairs);
        EXPECT_EQ(trianglesOf(mesh), std::size_t(triangles));
        EXPECT_EQ(repairs.summary(), triangles == 1280 ? "" : "many points, drawn with less detail");
        EXPECT_NEAR(areaOf(mesh), 4 * M_PI * 1.5 * 1.5, 1e-3);
        EXPECT_EQ(openEdgesOf(mesh), 0u);
        EXPECT_EQ(eulerOf(mesh), 2);
        EXPECT_GT(volumeOf(mesh), 0);
        EXPECT_LT(volumeOf(mesh), 4 * M_PI / 3 * 1.5 * 1.5 * 1.5) << "of one area the ball is the largest";
        for (std::size_t i = 0; i < mesh.points.size(); ++i) {
            EXPECT_LT(length(normalize(mesh.points[i] - set.points[0]) - mesh.normals[i]), 1e-5f);
        }
    }
}

TEST(PointSet, WidthsAndColorsOfEachAndOfAll) {
    PointSet set = row(2);
    set.widths = {1, 2};
    set.colors = {{1, 0, 0}, {0, 1, 0}};
    PointRepairs repairs;
    const ControlMesh mesh = tessellate(set, 0, plenty, repairs);
    EXPECT_EQ(repairs.summary(), "");
    EXPECT_NEAR(areaOf(mesh), M_PI * (1 + 4), 1e-3);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        EXPECT_EQ(mesh.colors[i], mesh.points[i].x < 2 ? Rgb(1, 0, 0) : Rgb(0, 1, 0));
    }
    set.widths = {};
    set.colors = {};
    const ControlMesh plain = tessellate(set, 0, plenty, repairs);
    EXPECT_TRUE(plain.colors.empty());
    EXPECT_NEAR(areaOf(plain), 2 * M_PI, 1e-3) << "without widths: 1";
}

TEST(PointSet, BadInputIsLeftOutAndSaid) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    PointSet set = row(5);
    set.points[0].x = nan;
    set.points[1].y = 2e18f;
    set.widths = {1, 1, nan, -1, 1};
    set.colors = std::vector<Rgb>(5, Rgb(nan));
    set.hidden = {99, -5};
    PointRepairs repairs;
    EXPECT_EQ(trianglesOf(tessellate(set, 0, plenty, repairs)), 80u);
    EXPECT_EQ(repairs.summary(),
              "2 points left out (not finite); 2 points left out (no width); 1 colors that are not finite set to zero");
    set.widths = {1, 2, 3};
    set.colors = {Rgb(1), Rgb(1)};
    set.hidden = {4, 3};
    repairs = {};
    EXPECT_EQ(trianglesOf(tessellate(set, 0, plenty, repairs)), 80u);
    EXPECT_TRUE(repairs.droppedWidths && repairs.droppedColors);
    repairs = {};
    EXPECT_TRUE(tessellate(PointSet(), 0, plenty, repairs).faceVertexCounts.empty());
}

TEST(PointSet, NumberOfTrianglesIsBounded) {
    for (const std::size_t most : {100000u, 20000u, 8000u, 4000u, 100u, 8u}) {
        PointRepairs repairs;
        const ControlMesh mesh = tessellate(row(1000), 2, most, repairs);
        EXPECT_LE(trianglesOf(mesh), most);
        EXPECT_GE(trianglesOf(mesh), most / 5);
        EXPECT_EQ(repairs.everyNth > 1, most < 8000);
        EXPECT_NE(repairs.summary(), "");
    }
}
