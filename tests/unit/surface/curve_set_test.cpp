// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/curve_set.h"

#include "tests/unit/surface/tessellation_measures.h"

#include <gtest/gtest.h>
#include <limits>

using namespace stf;
using namespace stf::test;

namespace {

constexpr std::size_t plenty = 1'000'000;
constexpr float notANumber = std::numeric_limits<float>::quiet_NaN();

CurveSet line(std::vector<Vec3f> points, float width) {
    CurveSet curves;
    curves.vertexCounts = {int(points.size())};
    curves.points = std::move(points);
    curves.widths.values = {width};
    return curves;
}

ControlMesh tessellated(const CurveSet& curves, int level = 2) {
    CurveRepairs repairs;
    const ControlMesh mesh = tessellate(curves, level, plenty, repairs);
    EXPECT_EQ(repairs.summary(), "");
    return mesh;
}

/// The centre of each ring of a tube without caps.
std::vector<Vec3d> ringCentres(const ControlMesh& mesh, int sides, std::size_t rings) {
    std::vector<Vec3d> centres(rings);
    for (std::size_t i = 0; i < rings * std::size_t(sides); ++i) {
        centres[i / std::size_t(sides)] += Vec3d(mesh.points[i]) / double(sides);
    }
    return centres;
}

} // namespace

TEST(CurveSet, ATubeIsClosedAndHasTheCylindersLateralArea) {
    const double radius = 0.5, tall = 3;
    for (const auto& [level, sides] : {std::pair(0, 4), {1, 6}, {2, 8}, {3, 12}, {7, 12}}) {
        const ControlMesh mesh = tessellated(line({{1, 2, 3}, {1, 2, 6}}, float(2 * radius)), level);
        EXPECT_EQ(mesh.faceVertexCounts.size(), std::size_t(sides + 2));
        // A regular polygon's area from its perimeter.
        const double cap = std::pow(2 * M_PI * radius, 2) / (4 * sides * std::tan(M_PI / sides));
        EXPECT_NEAR(areaOf(mesh), 2 * M_PI * radius * tall + 2 * cap, 1e-4);
        EXPECT_NEAR(volumeOf(mesh), cap * tall, 1e-4) << "outward faces";
        EXPECT_EQ(openEdgesOf(weldedByPlace(mesh)), 0u);
        for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
            EXPECT_NEAR(length(mesh.normals[i]), 1, 1e-5);
        }
    }
}

TEST(CurveSet, ABendKeepsTheWidthOfBothPieces) {
    // A right angle: opposite sides of each straight piece are as far apart as in a tube without a bend.
    const ControlMesh mesh = tessellated(line({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}}, 1));
    const ControlMesh straight = tessellated(line({{0, 0, 0}, {4, 0, 0}, {8, 0, 0}}, 1));
    EXPECT_NEAR(volumeOf(mesh), volumeOf(straight), 0.02 * volumeOf(straight));
}

TEST(CurveSet, StationsLieOnTheCurveOfEachBasis) {
    CurveSet curves = line({{0, 0, 0}, {1, 2, 0}, {3, 1, 0}, {4, 0, 1}}, 0.1f);
    const auto p = [&](std::size_t i) { return Vec3d(curves.points[i]); };
    const auto middleOf = [&](CurveSet::Basis basis) {
        curves.basis = basis;
        return ringCentres(tessellated(curves), 8, 7)[3]; // 6 pieces
    };
    // Closed forms at u = 1/2.
    EXPECT_LT(length(middleOf(CurveSet::Basis::Bezier) - (p(0) + p(1) * 3.0 + p(2) * 3.0 + p(3)) / 8.0), 1e-5);
    EXPECT_LT(length(middleOf(CurveSet::Basis::BSpline) - (p(0) + p(1) * 23.0 + p(2) * 23.0 + p(3)) / 48.0), 1e-5);
    EXPECT_LT(length(middleOf(CurveSet::Basis::CatmullRom) - (p(1) * 9.0 + p(2) * 9.0 - p(0) - p(3)) / 16.0), 1e-5);
}

TEST(CurveSet, PiecesAreWithinTheBoundOfTheCurve) {
    CurveSet curves = line({{0, 0, 0}, {0, 3, 0}, {3, 3, 0}, {3, 0, 0}}, 0.01f);
    curves.basis = CurveSet::Basis::Bezier;
    for (const auto& [level, sides, pieces] : {std::tuple(0, 4, 2), {1, 6, 4}, {2, 8, 6}, {3, 12, 8}}) {
        const std::vector<Vec3d> c = ringCentres(tessellated(curves, level), sides, std::size_t(pieces + 1));
        // C'' is 6 (P0 - 2 P1 + P2) at its largest, here (18, -18) either side: of length 18 sqrt(2).
        const double bound = 18 * std::sqrt(2.0) / (8.0 * pieces * pieces);
        double worst = 0;
        for (int i = 0; i < pieces; ++i) {
            const double u = (i + 0.5) / pieces, v = 1 - u;
            const Vec3d exact =
                Vec3d(0, 3, 0) * (3 * u * v * v) + Vec3d(3, 3, 0) * (3 * u * u * v) + Vec3d(3, 0, 0) * (u * u * u);
            worst = std::max(worst, length(exact - (c[std::size_t(i)] + c[std::size_t(i + 1)]) / 2.0));
        }
        EXPECT_LT(worst, bound);
        EXPECT_GT(worst, bound / 8) << "else this bounds nothing";
    }
}

TEST(CurveSet, APeriodicOneIsATorus) {
    CurveSet curves;
    constexpr int count = 64;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * M_PI * i / count;
        curves.points.push_back(Vec3f(Vec3d(2 * std::cos(angle), 2 * std::sin(angle), 0.5 * std::sin(2 * angle))));
    }
    curves.vertexCounts = {count};
    curves.widths.values = {0.5f};
    curves.wrap = CurveSet::Wrap::Periodic;
    for (const CurveSet::Basis basis :
         {CurveSet::Basis::Linear, CurveSet::Basis::CatmullRom, CurveSet::Basis::BSpline}) {
        curves.basis = basis;
        const ControlMesh mesh = tessellated(curves);
        EXPECT_EQ(openEdgesOf(mesh), 0u);
        EXPECT_EQ(eulerOf(mesh), 0);
        // Nowhere does the frame turn suddenly: quads are no longer across than twice what they are for a straight
        // tube.
        EXPECT_LT(longestEdgeOf(mesh), 0.35);
    }
    // Pappus: area is perimeter times the way of the centre, here of the flat circle.
    for (Vec3f& p : curves.points) {
        p.z = 0;
    }
    curves.basis = CurveSet::Basis::Linear;
    EXPECT_NEAR(areaOf(tessellated(curves, 3)), 2 * M_PI * 0.25 * 2 * M_PI * 2, 0.05);
}

TEST(CurveSet, RibbonsFaceAlongTheirNormals) {
    CurveSet curves = line({{0, 0, 0}, {3, 0, 0}}, 0.5f);
    curves.normals = {{{0, 0, 2}}, CurveSet::Interpolation::Constant};
    const ControlMesh mesh = tessellated(curves);
    EXPECT_NEAR(areaOf(mesh), 1.5, 1e-6);
    for (const Vec3f& n : mesh.normals) {
        EXPECT_NEAR(n.z, 1, 1e-6);
    }
    // A normal along the curve says nothing: any side will do.
    curves.normals.values = {{1, 0, 0}};
    EXPECT_NEAR(areaOf(tessellated(curves)), 1.5, 1e-6);
}

TEST(CurveSet, ValuesOfAllInterpolations) {
    using Interpolation = CurveSet::Interpolation;
    CurveSet curves;
    curves.basis = CurveSet::Basis::BSpline;
    curves.vertexCounts = {4, 5};
    for (int i = 0; i < 9; ++i) {
        curves.points.push_back({float(i), i < 4 ? 0.0f : 9.0f, 0});
    }
    EXPECT_EQ(curves.valueCount(Interpolation::Varying), 5u);
    const auto radiusAtEnd = [&](std::vector<float> widths, Interpolation interpolation) {
        curves.widths = {std::move(widths), interpolation};
        const ControlMesh mesh = tessellated(curves);
        double most = 0;
        for (const Vec3f& p : mesh.points) {
            most = std::max(most, std::abs(double(p.z)));
        }
        return most * std::sin(M_PI / 8) / (M_PI / 8);
    };
    EXPECT_NEAR(radiusAtEnd({3}, Interpolation::Constant), 1.5, 0.13);
    EXPECT_NEAR(radiusAtEnd({1, 2}, Interpolation::Uniform), 1, 0.09);
    EXPECT_NEAR(radiusAtEnd({1, 1, 1, 1, 4}, Interpolation::Varying), 2, 0.17);
    EXPECT_NEAR(radiusAtEnd({1, 1, 1, 1, 1, 1, 1, 1, 7}, Interpolation::Vertex), 0.5 * (1 + 6.0 / 6), 0.09);

    curves.widths = {{1}, Interpolation::Constant};
    curves.colors = {{{1, 0, 0}, {0, 1, 0}}, Interpolation::Uniform};
    const ControlMesh mesh = tessellated(curves);
    ASSERT_EQ(mesh.colors.size(), mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        EXPECT_EQ(mesh.colors[i], mesh.points[i].y < 4 ? Rgb(1, 0, 0) : Rgb(0, 1, 0));
    }
}

TEST(CurveSet, IndicesSegmentsPinnedAndHidden) {
    CurveSet curves = line({{0, 0, 0}, {9, 9, 9}, {2, 0, 0}, {5, 0, 0}}, 1);
    curves.vertexCounts = {3};
    curves.indices = {0, 2, 3};
    EXPECT_NEAR(extentOf(tessellated(curves)).hi.x, 5, 1e-6);
    curves.indices = {};
    curves.vertexCounts = {4};
    curves.wrap = CurveSet::Wrap::Segmented;
    EXPECT_EQ(tessellated(curves).faceVertexCounts.size(), 2u * (8 + 2));
    curves.wrap = CurveSet::Wrap::Pinned;
    curves.basis = CurveSet::Basis::BSpline;
    const std::vector<Vec3d> rings = ringCentres(tessellated(curves), 8, 3 * 6 + 1);
    EXPECT_LT(length(rings.front() - Vec3d(0, 0, 0)), 1e-5);
    EXPECT_LT(length(rings.back() - Vec3d(5, 0, 0)), 1e-5);
    curves.hidden = {0, 7, -1};
    EXPECT_TRUE(tessellated(curves).faceVertexCounts.empty());
}

TEST(CurveSet, BadInputIsLeftOutAndSaid) {
    CurveSet curves;
    curves.basis = CurveSet::Basis::Bezier;
    curves.points = std::vector<Vec3f>(14);
    for (std::size_t i = 0; i < curves.points.size(); ++i) {
        curves.points[i] = {float(i), 0, 0};
    }
    curves.points[10].y = notANumber;
    curves.vertexCounts = {4, 5, 4, 4};
    curves.widths = {{notANumber}, CurveSet::Interpolation::Constant};
    curves.colors = {{Rgb(1), Rgb(1), Rgb(1)}, CurveSet::Interpolation::Uniform};
    CurveRepairs repairs;
    EXPECT_TRUE(tessellate(curves, 2, plenty, repairs).faceVertexCounts.empty());
    EXPECT_EQ(repairs.summary(),
              "2 curves left out (the number of vertices does not fit); 1 curve left out (points that are not there or "
              "not finite); 1 curve left out (no length or no width); displayColor ignored (wrong count); 1 widths, "
              "colors or normals that are not usable set to zero");

    CurveSet few = line({{0, 0, 0}, {1, 0, 0}}, 1);
    for (const std::vector<int>& indices : {std::vector<int>{0, 5}, {0, -1}}) {
        few.indices = indices;
        repairs = {};
        EXPECT_TRUE(tessellate(few, 0, plenty, repairs).faceVertexCounts.empty());
        EXPECT_EQ(repairs.badPoints, 1);
    }
    few = line({{1, 1, 1}, {1, 1, 1}}, 1);
    repairs = {};
    EXPECT_TRUE(tessellate(few, 0, plenty, repairs).faceVertexCounts.empty());
    EXPECT_EQ(repairs.withoutExtent, 1);
    few.vertexCounts = {std::numeric_limits<int>::max(), -3};
    repairs = {};
    EXPECT_TRUE(tessellate(few, 0, plenty, repairs).faceVertexCounts.empty());
    EXPECT_EQ(repairs.wrongCounts, 2);
    repairs = {};
    EXPECT_TRUE(tessellate(CurveSet(), 0, plenty, repairs).faceVertexCounts.empty());
}

TEST(CurveSet, TurningBackAndRepeatedPointsAreFinite) {
    CurveSet curves = line({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 1, 0}}, 0.1f);
    for (const Vec3f& p : tessellated(curves).points) {
        EXPECT_TRUE(isFinite(p));
        EXPECT_LT(length(p), 1.5f);
    }
}

TEST(CurveSet, NumberOfTrianglesIsBounded) {
    CurveSet curves;
    for (int i = 0; i < 1000; ++i) {
        curves.vertexCounts.push_back(2);
        curves.points.push_back({float(i), 0, 0});
        curves.points.push_back({float(i), 1, 0});
    }
    curves.widths.values = {0.1f};
    for (const std::size_t most : {30000u, 15000u, 5000u, 100u, 8u, 3u, 0u}) {
        CurveRepairs repairs;
        const ControlMesh mesh = tessellate(curves, 2, most, repairs);
        EXPECT_LE(trianglesOf(mesh), most);
        EXPECT_EQ(repairs.everyNth > 1, most < 8000) << most;
        EXPECT_NE(repairs.summary(), most >= 28000 ? "?" : "");
        if (most >= 100) {
            EXPECT_GT(trianglesOf(mesh), most / 4) << "not fewer than need be";
        }
    }
}
