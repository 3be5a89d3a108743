// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/surface_charts.h"

#include "stfLib/base/parallel.h"
#include "stfLib/surface/direction_field.h"
#include "tests/unit/surface/test_meshes.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

struct Prepared {
    SurfaceGraph graph;
    std::vector<Vec3f> directions;
    SurfaceSteps steps;
    std::vector<char> singular;
};

Prepared prepare(ControlMesh mesh, double mmPerUnit) {
    Prepared p;
    Progress progress;
    sanitize(mesh);
    p.graph = surfaceGraph(refine(mesh, {}, {}));
    p.directions = smoothDirections(p.graph, {}, progress);
    p.steps = surfaceSteps(p.graph, p.directions, mmPerUnit);
    p.singular = singularVertices(p.graph, singularities(p.graph, p.directions));
    return p;
}

/// Root mean square of what steps around triangles leave over, away from singularities, over the step.
double loopError(const Prepared& p, const std::vector<Vec2f>& steps) {
    double sum = 0, square = 0;
    for (const Vec3i& t : p.graph.triangles) {
        if (p.singular[std::size_t(t.x)] || p.singular[std::size_t(t.y)] || p.singular[std::size_t(t.z)]) {
            continue;
        }
        Vec2f loop{0, 0};
        for (int c = 0; c < 3; ++c) {
            const Vec2f s = steps[std::size_t(linkOf(p.graph, t[c], t[(c + 1) % 3]))];
            loop = loop + s;
            square += double(s.x * s.x + s.y * s.y);
        }
        sum += double(loop.x * loop.x + loop.y * loop.y);
    }
    return std::sqrt(sum / square);
}

ChartCover coverOf(const Prepared& p, double spacing) {
    Progress progress;
    ChartOptions options;
    options.spacingMm = spacing;
    return coverByCharts(p.graph, p.steps, p.singular, options, progress);
}

} // namespace

TEST(SurfaceSteps, HaveTheLengthOfTheirEdgeAndTheWayBackIsTheOpposite) {
    const Prepared p = prepare(sphere(16), 10);
    for (std::size_t v = 0; v < p.graph.size(); ++v) {
        for (int k = p.graph.first[v]; k < p.graph.first[v + 1]; ++k) {
            const int u = p.graph.neighbour[std::size_t(k)];
            const Vec2f s = p.steps.stepMm[std::size_t(k)],
                        back = p.steps.stepMm[std::size_t(linkOf(p.graph, u, int(v)))];
            EXPECT_NEAR(std::hypot(s.x, s.y), 10 * length(p.graph.points[std::size_t(u)] - p.graph.points[v]), 1e-3);
            EXPECT_NEAR(s.x + back.x, 0, 1e-4);
            EXPECT_NEAR(s.y + back.y, 0, 1e-4);
        }
    }
}

TEST(SurfaceSteps, ScaleMakesThemAddUpAroundTriangles) {
    // A torus: its field is smooth everywhere and turns, since the surface is curved.
    Prepared p = prepare(torus(3, 1, 120, 60), 1);
    const double before = loopError(p, p.steps.stepMm);
    Progress progress;
    const std::vector<float> factor = scaleSteps(p.graph, 100, 3, 1, p.steps, progress);
    EXPECT_LT(loopError(p, p.steps.wantedMm), 0.4 * before);
    for (float f : factor) {
        EXPECT_GE(f, 1 / 3.0f);
        EXPECT_LE(f, 3.0f);
    }
}

TEST(SurfaceSteps, ScaleIsOneWhereTheFieldDoesNotTurn) {
    Prepared p = prepare(cylinder(1, 3, 60, 40), 1);
    Progress progress;
    for (float f : scaleSteps(p.graph, 10, 1.5, 1, p.steps, progress)) {
        EXPECT_NEAR(f, 1, 0.01);
    }
}

TEST(SurfaceCharts, EveryVertexIsInAChartWithoutMuchStretch) {
    const Prepared p = prepare(sphere(30), 10);
    const ChartCover cover = coverOf(p, 5);
    for (std::size_t v = 0; v < p.graph.size(); ++v) {
        EXPECT_GT(cover.first[v + 1], cover.first[v]) << v;
    }
    EXPECT_GT(cover.charts.size(), 10u);
    EXPECT_LT(cover.charts.size(), 200u);
    for (float s : cover.strain) {
        EXPECT_LT(s, 2 * 0.48 * 0.48); // both stretches below 1.6
    }
}

TEST(SurfaceCharts, OfAPlaneAreThePlane) {
    const Prepared p = prepare(rectangle(20, 20, 50, 50), 1);
    const ChartCover cover = coverOf(p, 6);
    for (const ChartCover::Chart& c : cover.charts) {
        const Vec3f seed = p.graph.points[std::size_t(c.seed)];
        for (int i = 0; i < c.count; ++i) {
            const Vec3f d = p.graph.points[std::size_t(cover.member[std::size_t(c.first + i)])] - seed;
            const Vec2f at = cover.coord[std::size_t(cover.entryOfMember[std::size_t(c.first + i)])];
            // The same distance from the middle, whichever way the field points.
            EXPECT_NEAR(std::hypot(at.x, at.y), length(d), 1e-3);
        }
    }
}

TEST(SurfaceCharts, MembersAndEntriesAgree) {
    const Prepared p = prepare(torus(3, 1, 60, 30), 5);
    const ChartCover cover = coverOf(p, 4);
    std::size_t entries = 0;
    for (std::size_t c = 0; c < cover.charts.size(); ++c) {
        for (int i = 0; i < cover.charts[c].count; ++i) {
            const int v = cover.member[std::size_t(cover.charts[c].first + i)];
            EXPECT_EQ(cover.entryAt(v, int(c)), cover.entryOfMember[std::size_t(cover.charts[c].first + i)]);
            ++entries;
        }
    }
    EXPECT_EQ(entries, cover.chart.size());
}

TEST(SurfaceCharts, DoNotDependOnThreads) {
    const Prepared p = prepare(sphere(24), 10);
    setThreadCount(1);
    const ChartCover one = coverOf(p, 5);
    setThreadCount(4);
    const ChartCover four = coverOf(p, 5);
    setThreadCount(0);
    EXPECT_EQ(one.chart, four.chart);
    EXPECT_EQ(one.coord, four.coord);
}
