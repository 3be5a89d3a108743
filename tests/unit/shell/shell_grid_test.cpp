// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "tests/unit/shell/shell_fixture.h"

#include <cstdio>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

TEST(ShellGrid, DepthOfASphereIsRadiusMinusDistance) {
    const double mm = 25;
    const Shell shell = ball(mm);
    ShellGrid::Accessor accessor(shell.grid);
    Points points(1);
    double worst = 0, sum = 0;
    const int count = 20000;
    for (int i = 0; i < count; ++i) {
        const Vec3d n = points.direction();
        const double r = points.uniform(0.9, 1.0);
        ShellLookup l;
        ASSERT_TRUE(accessor.lookup(Vec3f(n * r), l));
        const double error = double(l.depth) / mm - (1 - r);
        worst = std::max(worst, std::abs(error));
        sum += error;
        EXPECT_GT(dot(Vec3d(l.normal), n), 0.9999);
        EXPECT_NEAR(length(l.normal), 1, 1e-5);
    }
    // Facets of edge 0.05 lie up to 3e-4 below the sphere; the thickness is 0.1.
    EXPECT_LT(worst, 1.2e-3);
    EXPECT_LT(std::abs(sum / count), 4e-4);
}

TEST(ShellGrid, CoordinatesOfASphereFollowTheMapAtEveryDepth) {
    const Shell shell = ball();
    ShellGrid::Accessor accessor(shell.grid);
    Points points(2);
    double worst = 0, sumSquares = 0;
    const int count = 20000;
    for (int i = 0; i < count; ++i) {
        const Vec3d p = points.direction() * points.uniform(0.9, 1.0);
        ShellLookup l;
        ASSERT_TRUE(accessor.lookup(Vec3f(p), l));
        const Vec2d e = ballCoords(p);
        const double error = std::max(wrapped(double(l.exemplar.x) - e.x, 3), wrapped(double(l.exemplar.y) - e.y, 4));
        worst = std::max(worst, error);
        sumSquares += error * error;
    }
    // A voxel is 0.0125 units or 0.125 mm of the map.
    EXPECT_LT(worst, 0.02);
    EXPECT_LT(std::sqrt(sumSquares / count), 0.004);
}

// What the gradients foresee one voxel away is what a lookup there finds.
TEST(ShellGrid, GradientsAreConsistentWithLookupsOneVoxelAway) {
    const Shell shell = ball();
    ShellGrid::Accessor accessor(shell.grid);
    Points points(3);
    const double h = double(shell.grid.voxelSize());
    double sumSquares = 0, depthSquares = 0, gradientWorst = 0;
    int count = 0;
    while (count < 20000) {
        const Vec3d p = points.direction() * points.uniform(0.9, 1.0), q = p + points.direction() * h;
        if (length(q) > 1 || length(q) < 0.9) {
            continue;
        }
        ++count;
        ShellLookup a, b;
        ASSERT_TRUE(accessor.lookup(Vec3f(p), a) && accessor.lookup(Vec3f(q), b));
        const Vec3d step = Vec3d(Vec3f(q) - Vec3f(p));
        const double foreseen = double(a.exemplar.x) + dot(Vec3d(a.gradX), step);
        const double error = wrapped(double(b.exemplar.x) - foreseen, 3) / (10 * h);
        sumSquares += error * error;
        const double depthError = (double(b.depth) - (double(a.depth) - dot(Vec3d(a.normal), step))) / h;
        depthSquares += depthError * depthError;
        gradientWorst = std::max(gradientWorst, length(Vec3d(a.gradX) - ballGradient(axisX, p)) / 10);
    }
    EXPECT_LT(std::sqrt(sumSquares / count), 0.02);
    EXPECT_LT(std::sqrt(depthSquares / count), 0.02);
    EXPECT_LT(gradientWorst, 0.02);
}

TEST(ShellGrid, CoversTheShellAndNothingElse) {
    const Shell shell = ball();
    ShellGrid::Accessor accessor(shell.grid);
    ShellLookup l;
    Points points(4);
    for (int i = 0; i < 1000; ++i) {
        const Vec3f n(points.direction());
        // The facets are the surface that rays find.
        EXPECT_TRUE(accessor.lookup(n * 1.0f, l));
        EXPECT_TRUE(accessor.lookup(n * 0.8985f, l));
        EXPECT_FALSE(accessor.lookup(n * 1.1f, l));
        EXPECT_FALSE(accessor.lookup(n * 0.8f, l));
    }
    EXPECT_FALSE(accessor.lookup({0, 0, 0}, l));
    EXPECT_FALSE(accessor.lookup({std::nanf(""), 0, 0}, l));
    EXPECT_FALSE(accessor.lookup({1e30f, 0, 0}, l));
    EXPECT_FALSE(accessor.lookup({INFINITY, 0, 0}, l));
    ShellGrid empty;
    EXPECT_FALSE(ShellGrid::Accessor(empty).lookup({0, 0, 0}, l));
}

TEST(ShellGrid, PlaneIsExact) {
    const Shell shell = tiled(rectangle(1, 1, 4, 4), 0.1f, {0.3, 0.4});
    ShellGrid::Accessor accessor(shell.grid);
    Points points(5);
    for (int i = 0; i < 5000; ++i) {
        const Vec3d p(points.uniform(0, 1), points.uniform(0, 1), points.uniform(-0.1, 0));
        ShellLookup l;
        ASSERT_TRUE(accessor.lookup(Vec3f(p), l)) << p.x << " " << p.y << " " << p.z;
        EXPECT_NEAR(double(l.depth), -p.z, 2e-6);
        EXPECT_LT(wrapped(double(l.exemplar.x) - p.x, 0.3), 2e-5);
        EXPECT_LT(wrapped(double(l.exemplar.y) - p.y, 0.4), 2e-5);
        EXPECT_NEAR(l.gradX.x, 1, 1e-4);
        EXPECT_NEAR(l.gradY.y, 1, 1e-4);
    }
    ShellLookup l;
    EXPECT_FALSE(accessor.lookup({-0.05f, 0.5f, -0.05f}, l)) << "nothing beyond an open boundary";
    EXPECT_FALSE(accessor.lookup({0.5f, 0.5f, 0.05f}, l));
}

// Whole tiles around: coordinates continue across the seam of the texture coordinates.
TEST(ShellGrid, AClosedTurnHasNoSeam) {
    const double tile = 0.3;
    const Shell shell = tiled(cylinder(1, 1, 128, 16), 0.1f, {tile, tile});
    ShellGrid::Accessor accessor(shell.grid);
    const double tiles = std::round(2 * pi / tile);
    Points points(6);
    for (int i = 0; i < 5000; ++i) {
        const double a = points.uniform(-0.05, 0.05), r = points.uniform(0.9, 0.999);
        ShellLookup l;
        ASSERT_TRUE(accessor.lookup(Vec3f(Vec3d(r * std::cos(a), r * std::sin(a), points.uniform(0.1, 0.9))), l));
        EXPECT_LT(wrapped(double(l.exemplar.x) - tiles * tile * a / (2 * pi), tile), 2e-3);
    }
}

// Where tiles do not fit, both sides of a seam keep their own coordinate and are never mixed.
TEST(ShellGrid, CoordinatesAreNotMixedAcrossASeam) {
    const Vec2d tile{1, 1};
    const RefinedSurface s = refined(rectangle(1, 1, 8, 8));
    ExemplarMap map;
    map.tileMm = tile;
    const auto jump = [](double x) { return x < 0.5 ? 0.0 : 0.37; };
    for (const Vec3i& t : s.triangles) {
        double middle = 0;
        for (int c = 0; c < 3; ++c) {
            middle += double(s.points[std::size_t(t[c])].x) / 3;
        }
        for (int c = 0; c < 3; ++c) {
            const Vec3f p = s.points[std::size_t(t[c])];
            map.cornerCoords.push_back({float(double(p.x) + jump(middle)), p.y});
            map.gradientX.push_back({1, 0, 0});
            map.gradientY.push_back({0, 1, 0});
        }
    }
    const ShellGrid grid = build(s, offsetInward(s, 0.1f, {}), map);
    ShellGrid::Accessor accessor(grid);
    Points points(7);
    for (int i = 0; i < 5000; ++i) {
        const Vec3d p(points.uniform(0.45, 0.55), points.uniform(0.1, 0.9), points.uniform(-0.1, 0));
        ShellLookup l;
        ASSERT_TRUE(accessor.lookup(Vec3f(p), l));
        const double left = wrapped(double(l.exemplar.x) - p.x, 1),
                     right = wrapped(double(l.exemplar.x) - p.x - 0.37, 1);
        EXPECT_LT(std::min(left, right), 1e-4);
        // The side changes within a voxel of the seam.
        if (std::abs(p.x - 0.5) > double(grid.voxelSize())) {
            EXPECT_LT(p.x < 0.5 ? left : right, 1e-4);
        }
    }
}

TEST(ShellGrid, AThinPlateTakesTheNearerSide) {
    ControlMesh mesh = cube(ControlMesh::Scheme::None);
    for (Vec3f& p : mesh.points) {
        p.z *= 0.05f;
    }
    for (int i : mesh.faceVertexIndices) {
        mesh.uvIndices.push_back(i);
    }
    for (const Vec3f& p : mesh.points) {
        mesh.uvs.push_back({p.x + p.z, p.y + p.z});
    }
    const Shell shell = tiled(mesh, 0.2f, {0.5, 0.5}, 0.1f);
    ShellGrid::Accessor accessor(shell.grid);
    Points points(8);
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
        const Vec3d p(points.uniform(-0.7, 0.7), points.uniform(-0.7, 0.7), points.uniform(-0.05, 0.05));
        ShellLookup l;
        if (!accessor.lookup(Vec3f(p), l)) {
            continue;
        }
        ++inside;
        EXPECT_GE(l.depth, -1e-3f);
        EXPECT_NEAR(double(l.depth), 0.05 - std::abs(p.z), 0.012);
        if (std::abs(p.z) > 0.01) {
            EXPECT_GT(double(l.normal.z) * p.z, 0);
        }
    }
    EXPECT_GT(inside, 4000);
}

TEST(ShellGrid, FoldOverIsReported) {
    const RefinedSurface s = refined(sphere(16));
    ShellBoundary boundary;
    boundary.thickness.assign(s.points.size(), 1.5f); // beyond the centre
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        boundary.inner.push_back(s.points[i] - s.normals[i] * 1.5f);
    }
    const ExemplarMap map = analyticMap(
        s, {1, 1}, ballCoords, [](const Vec3d& p) { return ballGradient(axisX, p); },
        [](const Vec3d& p) { return ballGradient(axisY, p); });
    Messages messages;
    const ShellGrid grid = build(s, boundary, map, 1, 0.05f, messages.sink());
    ShellGrid::Accessor accessor(grid);
    ShellLookup l;
    // Where prisms overlap the nearer surface wins: still radius minus distance.
    ASSERT_TRUE(accessor.lookup({0.3f, 0.1f, 0.2f}, l));
    EXPECT_NEAR(l.depth, 1 - std::sqrt(0.14), 0.02);

    // A saddle offset beyond its focus has nothing else to claim the voxels.
    ControlMesh mesh = cylinder(1, 4, 64, 4);
    mesh.faceVertexCounts.resize(16); // a quarter of the first ring
    mesh.faceVertexIndices.resize(64);
    mesh.uvIndices.resize(64);
    const RefinedSurface arc = refined(mesh);
    boundary = {};
    boundary.thickness.assign(arc.points.size(), 1.8f);
    for (std::size_t i = 0; i < arc.points.size(); ++i) {
        boundary.inner.push_back(arc.points[i] - arc.normals[i] * 1.8f);
    }
    build(arc, boundary, tileByUv(arc, {1, 1}, 1, {}), 1, 0.05f, messages.sink());
    EXPECT_TRUE(messages.has("folds over")) << messages.text;
}

TEST(ShellGrid, HardEdgesAndTorusAreCoveredWithoutHoles) {
    ControlMesh box = cube(ControlMesh::Scheme::None);
    for (int i : box.faceVertexIndices) {
        box.uvIndices.push_back(i);
    }
    for (const Vec3f& p : box.points) {
        box.uvs.push_back({p.x + 0.5f * p.z, p.y + 0.3f * p.z});
    }
    for (const ControlMesh& mesh : {box, torus(1, 0.4, 96, 48)}) {
        const Shell shell = tiled(mesh, 0.1f, {0.5, 0.5}, 0.15f);
        ShellGrid::Accessor accessor(shell.grid);
        Points points(9);
        int missing = 0;
        for (int i = 0; i < 20000; ++i) {
            const std::size_t t = std::size_t(points.uniform(0, double(shell.surface.triangles.size()) - 1e-6));
            double a = points.uniform(0, 1), b = points.uniform(0, 1);
            if (a + b > 1) {
                a = 1 - a, b = 1 - b;
            }
            const double share = points.uniform(0, 1), w[3] = {1 - a - b, a, b};
            Vec3d p;
            double depth = 0;
            for (int c = 0; c < 3; ++c) {
                const std::size_t v = std::size_t(shell.surface.triangles[t][c]);
                p += (Vec3d(shell.surface.points[v]) * (1 - share) + Vec3d(shell.boundary.inner[v]) * share) * w[c];
                depth += w[c] * share * double(shell.boundary.thickness[v]);
            }
            ShellLookup l;
            missing += !accessor.lookup(Vec3f(p), l);
            // At a mitre the nearest corner may belong to the other face, whose depth differs by less than a voxel.
            EXPECT_NEAR(double(l.depth), depth, double(shell.grid.voxelSize()));
        }
        EXPECT_EQ(missing, 0);
    }
}

TEST(ShellGrid, CoreRadianceIsInterpolatedOverTheSurface) {
    const Shell shell = ball();
    std::vector<Rgb> radiance;
    for (const Vec3f& p : shell.surface.points) {
        radiance.push_back(Rgb(2 + p.x, 2 + p.y, 2 + p.z));
    }
    ShellLookup l;
    ASSERT_TRUE(ShellGrid::Accessor(shell.grid).lookup({0, 0, 0.95f}, l));
    EXPECT_EQ(l.coreRadiance, Rgb());
    const std::vector<Rgb> spread = shell.grid.spreadCoreRadiance(radiance);
    ASSERT_EQ(spread.size(), shell.grid.sampleCount());
    ShellGrid::Accessor accessor(shell.grid);
    Points points(10);
    for (int i = 0; i < 2000; ++i) {
        const Vec3d n = points.direction();
        ASSERT_TRUE(accessor.lookup(Vec3f(n * 0.91), l, spread.data()));
        EXPECT_NEAR(length(Vec3d(l.coreRadiance) - (Vec3d(2) + n)), 0, 0.004);
    }
    EXPECT_THROW(shell.grid.spreadCoreRadiance({}), Error);
}

TEST(ShellGrid, DoesNotDependOnTheNumberOfThreads) {
    setThreadCount(1);
    const Shell one = tiled(torus(1, 0.4, 64, 32), 0.1f, {0.5, 0.5});
    setThreadCount(2);
    const Shell two = tiled(torus(1, 0.4, 64, 32), 0.1f, {0.5, 0.5});
    setThreadCount(0);
    EXPECT_EQ(one.grid.sampleCount(), two.grid.sampleCount());
    ShellGrid::Accessor a(one.grid), b(two.grid);
    Points points(11);
    for (int i = 0; i < 5000; ++i) {
        const Vec3f p(Vec3d(points.uniform(-1.5, 1.5), points.uniform(-1.5, 1.5), points.uniform(-0.5, 0.5)));
        ShellLookup la, lb;
        const bool found = a.lookup(p, la);
        ASSERT_EQ(found, b.lookup(p, lb));
        if (found) {
            ASSERT_TRUE(la.exemplar == lb.exemplar && la.depth == lb.depth && la.gradX == lb.gradX);
        }
    }
}

// Scaling a scene scales nothing but lengths.
TEST(ShellGrid, IsScaleInvariant) {
    for (double scale : {1e-6, 1e6}) {
        const Shell shell = ball(25 / scale, scale);
        ShellGrid::Accessor accessor(shell.grid);
        Points points(12);
        for (int i = 0; i < 2000; ++i) {
            const Vec3d n = points.direction();
            const double r = points.uniform(0.9, 1.0);
            ShellLookup l;
            ASSERT_TRUE(accessor.lookup(Vec3f(n * (r * scale)), l));
            EXPECT_NEAR(double(l.depth) / 25, 1 - r, 1.2e-3);
        }
    }
}

TEST(ShellGrid, FarFromTheOriginFloatsAreTheLimitOnly) {
    ControlMesh mesh = rectangle(100, 100, 4, 4);
    for (Vec3f& p : mesh.points) {
        p += Vec3f(1e6f);
    }
    const Shell shell = tiled(mesh, 10, {30, 30});
    ShellLookup l;
    ASSERT_TRUE(ShellGrid::Accessor(shell.grid).lookup(Vec3f(1e6f + 50, 1e6f + 50, 1e6f - 5), l));
    EXPECT_NEAR(l.depth, 5, 0.1);
}

TEST(ShellGrid, TooFineAVoxelSizeIsRaisedWithAMessage) {
    const RefinedSurface s = refined(rectangle(1, 1, 1, 1));
    Messages messages;
    ShellGridOptions options;
    options.voxelSize = 1e-4f;
    options.maxBytes = 2 << 20;
    Progress progress;
    const ShellGrid grid =
        ShellGrid::build(s, offsetInward(s, 0.05f, {}), tileByUv(s, {1, 1}, 1, {}), options, progress, messages.sink());
    EXPECT_TRUE(messages.has("to stay within 2 MB")) << messages.text;
    EXPECT_LT(grid.memoryBytes(), std::size_t(2.3 * (1 << 20)));
    EXPECT_GT(grid.memoryBytes(), std::size_t(1) << 20);
    EXPECT_GT(grid.memoryBytes(), grid.sampleCount() * 32);
}

TEST(ShellGrid, OneSlantedTriangleDoesNotFillItsBox) {
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    mesh.points = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    addFace(mesh, {0, 1, 2});
    mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
    mesh.uvIndices = {0, 1, 2};
    const Shell shell = tiled(mesh, 0.02f, {0.5, 0.5});
    // Area sqrt(3) / 2, thickness 8 voxels and 1.8 beyond both sides, voxel 0.0025.
    EXPECT_NEAR(double(shell.grid.levels().front().samples), std::sqrt(3.0) / 2 * 0.029 / std::pow(0.0025, 3), 3e4);
    ShellGrid::Accessor accessor(shell.grid);
    ShellLookup l;
    const Vec3f n = normalize(Vec3f(1));
    ASSERT_TRUE(accessor.lookup(Vec3f(1.0f / 3) - n * 0.007f, l));
    EXPECT_NEAR(l.depth, 0.007, 1e-5);
    EXPECT_GT(dot(l.normal, n), 0.99999f);
}

TEST(ShellGrid, DegenerateTrianglesHaveNoShell) {
    RefinedSurface s = refined(rectangle(1, 1, 4, 4));
    ExemplarMap map = tileByUv(s, {0.5, 0.5}, 1, {});
    const ShellBoundary boundary = offsetInward(s, 0.1f, {});
    s.triangles[3] = {2, 2, 2};
    map.gradientX[0] = Vec3f(std::nanf(""));
    map.cornerCoords[20].x = std::nanf("");
    Messages messages;
    const ShellGrid grid = build(s, boundary, map, 1, 0, messages.sink());
    EXPECT_TRUE(messages.has("1 triangles without area"));
    ShellGrid::Accessor accessor(grid);
    Points points(13);
    for (int i = 0; i < 2000; ++i) {
        ShellLookup l;
        if (accessor.lookup(Vec3f(Vec3d(points.uniform(0, 1), points.uniform(0, 1), points.uniform(-0.1, 0))), l)) {
            ASSERT_TRUE(isFinite(l.gradX) && std::isfinite(l.exemplar.x) && std::isfinite(l.depth));
        }
    }
}

TEST(ShellGrid, CancelsAndReportsProgress) {
    const RefinedSurface s = refined(rectangle(1, 1, 8, 8));
    const ShellBoundary boundary = offsetInward(s, 0.1f, {});
    const ExemplarMap map = tileByUv(s, {1, 1}, 1, {});
    double last = 0;
    Progress counting([&](const std::string&, double f) { last = f; });
    ShellGrid::build(s, boundary, map, {}, counting, {});
    EXPECT_EQ(last, 1);
    Progress cancelled;
    cancelled.cancel();
    EXPECT_THROW(ShellGrid::build(s, boundary, map, {}, cancelled, {}), Cancelled);
}

TEST(ShellGrid, RefusesDataThatDoNotBelongTogether) {
    const RefinedSurface s = refined(rectangle(1, 1, 2, 2));
    const ShellBoundary boundary = offsetInward(s, 0.1f, {});
    const ExemplarMap map = tileByUv(s, {1, 1}, 1, {});
    EXPECT_THROW(build({}, boundary, map), Error);
    EXPECT_THROW(build(s, {}, map), Error);
    EXPECT_THROW(build(s, boundary, {}), Error);
}

TEST(ShellGrid, WritesGridsForInspection) {
    const Shell shell = tiled(rectangle(1, 1, 2, 2), 0.2f, {0.5, 0.5});
    const std::string path = testing::TempDir() + "stf_shell_grid_test.vdb";
    shell.grid.write(path);
    std::FILE* file = std::fopen(path.c_str(), "rb");
    ASSERT_NE(file, nullptr);
    std::fseek(file, 0, SEEK_END);
    EXPECT_GT(std::ftell(file), 1000);
    std::fclose(file);
    std::remove(path.c_str());
    EXPECT_THROW(shell.grid.write("/nonexistent/x.vdb"), Error);
}
