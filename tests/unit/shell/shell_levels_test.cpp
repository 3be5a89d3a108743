// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/shell/shell_sample.h"
#include "tests/unit/shell/shell_fixture.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

ShellGrid built(const Shell& s, const ShellGridOptions& options, const MessageSink& sink = {}) {
    Progress progress;
    return ShellGrid::build(s.surface, s.boundary, s.map, options, progress, sink);
}

/// A finely faceted cylinder of radius 1 about z, with coordinates R angle and z: whole tiles fit around.
struct Tube : Shell {
    static constexpr double tiles = 20, tile = 2 * pi / tiles;

    explicit Tube(float thickness = 0.2f) {
        surface = refined(cylinder(1, 1, 1024, 8));
        boundary = offsetInward(surface, thickness, {});
        map.tileMm = {tile, tile};
        for (const Vec3i& t : surface.triangles) {
            double first = 0;
            for (int c = 0; c < 3; ++c) {
                const Vec3d p(surface.points[std::size_t(t[c])]);
                double a = std::atan2(p.y, p.x);
                first = c == 0 ? a : first;
                a = first + std::remainder(a - first, 2 * pi);
                map.cornerCoords.push_back({float(a), float(p.z)});
                map.gradientX.push_back(Vec3f(Vec3d(-std::sin(a), std::cos(a), 0)));
                map.gradientY.push_back({0, 0, 1});
            }
        }
    }
};

struct Errors {
    double coordinate = 0, depth = 0; ///< rms
};

/// Against the cylinder's closed form, at points away from its ends.
Errors errorsOf(const ShellGrid& grid, int level) {
    ShellGrid::Accessor accessor(grid);
    Points points(21);
    Errors sum;
    const int count = 5000;
    for (int i = 0; i < count; ++i) {
        const double a = points.uniform(-pi, pi), r = points.uniform(0.8, 0.999), z = points.uniform(0.3, 0.7);
        ShellLookup l;
        EXPECT_TRUE(accessor.lookup(Vec3f(Vec3d(r * std::cos(a), r * std::sin(a), z)), l, nullptr, level));
        const double x = wrapped(double(l.exemplar.x) - a, Tube::tile),
                     y = wrapped(double(l.exemplar.y) - z, Tube::tile);
        sum.coordinate += x * x + y * y;
        sum.depth += std::pow(double(l.depth) - (1 - r), 2);
    }
    return {std::sqrt(sum.coordinate / count), std::sqrt(sum.depth / count)};
}

} // namespace

TEST(ShellLevels, HalveTheVoxelAndConvergeToTheCylinder) {
    Tube tube;
    ShellGridOptions options;
    options.voxelSize = 0.0125f;
    const ShellGrid grid = built(tube, options);
    ASSERT_EQ(grid.levelCount(), 5); // up to the thickness
    Errors coarser;
    for (int level = 4; level >= 0; --level) {
        EXPECT_FLOAT_EQ(grid.voxelSize(level), 0.0125f * float(1 << level));
        const Errors e = errorsOf(grid, level);
        // Depth is trilinear: second order. Coordinates are of third, until facets and packing are what is left.
        if (level < 4 && level > 0) {
            EXPECT_GT(std::log2(coarser.depth / e.depth), 1.7) << level << " " << e.depth;
            EXPECT_GT(std::log2(coarser.coordinate / e.coordinate), level > 1 ? 2.2 : 1.5)
                << level << " " << e.coordinate;
        }
        coarser = e;
    }
    EXPECT_LT(coarser.depth, 3e-5);
    EXPECT_LT(coarser.coordinate, 1e-5);
}

TEST(ShellLevels, MeasuredErrorsAreThoseOfTheClosedForm) {
    Tube tube;
    ShellGridOptions options;
    options.voxelSize = 0.05f;
    options.texelMm = Tube::tile / 32;
    const ShellGrid grid = built(tube, options);
    EXPECT_GT(grid.report().probes, 8000u);
    for (int level = 0; level < grid.levelCount(); ++level) {
        const ShellLevelReport& r = grid.levels()[std::size_t(level)];
        const Errors e = errorsOf(grid, level);
        EXPECT_NEAR(r.depthTexels * options.texelMm, e.depth, 0.15 * e.depth) << level;
        EXPECT_NEAR(r.depthVoxels * r.voxel, e.depth, 0.15 * e.depth) << level;
        EXPECT_NEAR(r.exemplarTexels * options.texelMm, e.coordinate, 0.25 * e.coordinate + 1e-6) << level;
        EXPECT_EQ(r.missingShare, 0);
        EXPECT_EQ(r.seamWrongShare, 0);
    }
}

TEST(ShellLevels, APlaneIsExactAtEveryLevel) {
    Shell s = tiled(rectangle(1, 1, 4, 4), 0.1f, {0.3, 0.4});
    ASSERT_GE(s.grid.levelCount(), 4);
    ShellGrid::Accessor accessor(s.grid);
    Points points(22);
    for (int level = 0; level < s.grid.levelCount(); ++level) {
        for (int i = 0; i < 2000; ++i) {
            const Vec3d p(points.uniform(0, 1), points.uniform(0, 1), points.uniform(-0.1, 0));
            ShellLookup l;
            ASSERT_TRUE(accessor.lookup(Vec3f(p), l, nullptr, level)) << level;
            EXPECT_NEAR(double(l.depth), -p.z, 1e-5);
            EXPECT_LT(wrapped(double(l.exemplar.x) - p.x, 0.3), 4e-5);
            EXPECT_LT(wrapped(double(l.exemplar.y) - p.y, 0.4), 4e-5);
        }
    }
}

// A jump of the coordinates along a line: at no level is there anything between both sides, and what sees the wrong
// side lies within a voxel.
TEST(ShellLevels, SeamsAreMixedAtNoLevel) {
    Shell s;
    s.surface = refined(rectangle(1, 1, 8, 8));
    s.boundary = offsetInward(s.surface, 0.1f, {});
    s.map.tileMm = {1, 1};
    for (const Vec3i& t : s.surface.triangles) {
        double middle = 0;
        for (int c = 0; c < 3; ++c) {
            middle += double(s.surface.points[std::size_t(t[c])].x) / 3;
        }
        for (int c = 0; c < 3; ++c) {
            const Vec3f p = s.surface.points[std::size_t(t[c])];
            s.map.cornerCoords.push_back({float(double(p.x) + (middle < 0.5 ? 0.0 : 0.37)), p.y});
            s.map.gradientX.push_back({1, 0, 0});
            s.map.gradientY.push_back({0, 1, 0});
        }
    }
    ShellGridOptions options;
    options.voxelSize = 0.0117f;
    const ShellGrid grid = built(s, options);
    ASSERT_GE(grid.levelCount(), 4);
    EXPECT_NEAR(grid.report().seamLength, 1, 1e-6);
    ShellGrid::Accessor accessor(grid);
    Points points(23);
    for (int level = 0; level < grid.levelCount(); ++level) {
        const double voxel = double(grid.voxelSize(level));
        int wrong = 0, near = 0;
        for (int i = 0; i < 5000; ++i) {
            const Vec3d p(points.uniform(0.35, 0.65), points.uniform(0.1, 0.9), points.uniform(-0.1, 0));
            ShellLookup l;
            ASSERT_TRUE(accessor.lookup(Vec3f(p), l, nullptr, level));
            const double left = wrapped(double(l.exemplar.x) - p.x, 1),
                         right = wrapped(double(l.exemplar.x) - p.x - 0.37, 1);
            EXPECT_LT(std::min(left, right), 1e-4) << level;
            const bool isWrong = (p.x < 0.5 ? left : right) > 1e-3;
            near += std::abs(p.x - 0.5) < voxel;
            wrong += isWrong;
            EXPECT_TRUE(!isWrong || std::abs(p.x - 0.5) < voxel) << level;
        }
        const ShellLevelReport& r = grid.levels()[std::size_t(level)];
        EXPECT_NEAR(r.seamWrongShare, double(wrong) / near, 0.05) << level;
        EXPECT_NEAR(r.seamTexels, r.seamWrongShare * 2 * voxel * 64, 1e-6);
    }
}

TEST(ShellLevels, RefinementStopsWhereTheErrorIsMet) {
    Tube tube;
    ShellGridOptions options;
    options.texelMm = Tube::tile / 32;
    double before = 1;
    for (double wanted : {0.05, 0.0125, 0.003}) {
        options.errorTexels = wanted;
        Messages messages;
        const ShellGrid grid = built(tube, options, messages.sink());
        EXPECT_TRUE(messages.text.empty()) << messages.text;
        EXPECT_TRUE(grid.report().errorMet);
        EXPECT_LE(errorsOf(grid, 0).depth, 1.15 * wanted * options.texelMm);
        // No finer than it must be: an error of second order, and voxels are halved.
        EXPECT_GT(grid.levels().front().errorTexels(), wanted / 5);
        EXPECT_LT(double(grid.voxelSize()), before);
        before = double(grid.voxelSize());
    }
}

TEST(ShellLevels, TheMemoryLimitSaysWhichErrorIsLeft) {
    Tube tube;
    ShellGridOptions options;
    options.texelMm = Tube::tile / 32;
    options.errorTexels = 1e-3;
    options.maxBytes = 4 << 20;
    Messages messages;
    const ShellGrid grid = built(tube, options, messages.sink());
    EXPECT_FALSE(grid.report().errorMet);
    EXPECT_TRUE(messages.has("the memory limit allows")) << messages.text;
    EXPECT_LT(grid.memoryBytes(), std::size_t(5) << 20);
    EXPECT_GT(grid.levels().front().errorTexels(), 1e-3);
}

TEST(ShellLevels, ASampleTakesLessThan45Bytes) {
    Tube tube;
    ShellGridOptions options;
    options.voxelSize = 0.01f;
    const ShellGrid grid = built(tube, options);
    ASSERT_GT(grid.sampleCount(), 500000u);
    EXPECT_LT(double(grid.memoryBytes()), 45.0 * double(grid.sampleCount()));
    EXPECT_GT(double(grid.memoryBytes()), 32.0 * double(grid.sampleCount()));
}

TEST(ShellLevels, AFootprintTakesTheCoarsestLevelThatIsGoodEnough) {
    Tube tube;
    ShellGridOptions options;
    options.voxelSize = 0.0125f;
    const ShellGrid grid = built(tube, options);
    EXPECT_EQ(grid.levelFor(0), 0);
    EXPECT_EQ(grid.levelFor(1e9f), grid.levelCount() - 1);
    int before = 0;
    for (float mm = 1e-4f; mm < 10; mm *= 1.5f) {
        const int level = grid.levelFor(mm);
        EXPECT_GE(level, before);
        before = level;
        if (level > 0) {
            const Errors e = errorsOf(grid, level);
            EXPECT_LT(std::max(e.depth, e.coordinate), 0.12 * double(mm));
        }
    }
    EXPECT_EQ(ShellGrid().levelFor(1), 0);
}

TEST(ShellLevels, DoNotDependOnTheNumberOfThreads) {
    const auto make = [](int threads) {
        setThreadCount(threads);
        Tube tube;
        ShellGridOptions options;
        options.errorTexels = 0.05;
        ShellGrid grid = built(tube, options);
        setThreadCount(0);
        return grid;
    };
    const ShellGrid one = make(1), three = make(3);
    ASSERT_EQ(one.levelCount(), three.levelCount());
    ShellGrid::Accessor a(one), b(three);
    Points points(24);
    for (int level = 0; level < one.levelCount(); ++level) {
        const ShellLevelReport &x = one.levels()[std::size_t(level)], &y = three.levels()[std::size_t(level)];
        EXPECT_EQ(x.samples, y.samples);
        EXPECT_EQ(x.exemplarTexels, y.exemplarTexels);
        EXPECT_EQ(x.depthTexels, y.depthTexels);
        for (int i = 0; i < 1000; ++i) {
            const Vec3f p(Vec3d(points.uniform(-1, 1), points.uniform(-1, 1), points.uniform(0, 1)));
            ShellLookup l, m;
            const bool found = a.lookup(p, l, nullptr, level);
            ASSERT_EQ(found, b.lookup(p, m, nullptr, level));
            ASSERT_TRUE(!found || (l.exemplar == m.exemplar && l.depth == m.depth && l.triangle == m.triangle));
        }
    }
}

TEST(ShellLevels, ALookupNamesThePlaceOnTheSurfaceAboveIt) {
    Tube tube;
    ShellGridOptions options;
    options.voxelSize = 0.02f;
    const ShellGrid grid = built(tube, options);
    ShellGrid::Accessor accessor(grid);
    Points points(25);
    for (int level = 0; level < grid.levelCount(); ++level) {
        for (int i = 0; i < 1000; ++i) {
            const double a = points.uniform(-pi, pi), r = points.uniform(0.8, 0.999), z = points.uniform(0.3, 0.7);
            ShellLookup l;
            ASSERT_TRUE(accessor.lookup(Vec3f(Vec3d(r * std::cos(a), r * std::sin(a), z)), l, nullptr, level));
            const Vec3i& t = tube.surface.triangles[l.triangle];
            const Vec3d foot = Vec3d(tube.surface.points[std::size_t(t.x)]) * double(1 - l.b1 - l.b2) +
                               Vec3d(tube.surface.points[std::size_t(t.y)]) * double(l.b1) +
                               Vec3d(tube.surface.points[std::size_t(t.z)]) * double(l.b2);
            // Half a voxel's diagonal, spread outward by the curvature.
            EXPECT_LT(length(foot - Vec3d(std::cos(a), std::sin(a), z)),
                      0.87 / 0.7 * double(grid.voxelSize(level)) + 1e-4);
        }
    }
}

TEST(ShellLevels, ACodecKeepsWhatItSays) {
    ShellCodec codec;
    codec.tileMm = {38.4, 19.2};
    codec.depthLow = -0.7;
    codec.depthStep = 9.0 / 65535;
    Points points(26);
    for (int i = 0; i < 20000; ++i) {
        ShellPoint p;
        p.exemplar = {points.uniform(-100, 100), points.uniform(-100, 100)};
        p.depth = points.uniform(-0.7, 8.3);
        p.normal = points.direction();
        const double scale = std::pow(10.0, points.uniform(-3, 3));
        p.gradX = points.direction() * scale;
        p.gradY = points.direction() * scale;
        p.triangle = std::uint32_t(i) * 200000u;
        p.b1 = float(points.uniform(0, 0.5));
        p.b2 = float(points.uniform(0, 0.5));
        const ShellPoint q = codec.unpack(codec.pack(p));
        EXPECT_LT(wrapped(q.exemplar.x - p.exemplar.x, 38.4), 38.4 * 0x1p-24);
        EXPECT_LT(wrapped(q.exemplar.y - p.exemplar.y, 19.2), 19.2 * 0x1p-24);
        EXPECT_NEAR(q.depth, p.depth, 0.51 * codec.depthStep);
        EXPECT_LT(length(q.normal - p.normal), 6.6e-5); // half a step's diagonal, stretched threefold at most
        for (int a = 0; a < 3; ++a) {                   // halves: 11 bits, and nothing below 2^-14
            EXPECT_NEAR(q.gradX[a], p.gradX[a], std::abs(p.gradX[a]) * 0x1p-11 + 0x1p-14);
            EXPECT_NEAR(q.gradY[a], p.gradY[a], std::abs(p.gradY[a]) * 0x1p-11 + 0x1p-14);
        }
        EXPECT_EQ(q.triangle, p.triangle);
        EXPECT_NEAR(q.b1, p.b1, 1e-5);
        EXPECT_NEAR(q.b2, p.b2, 1e-5);
    }
    EXPECT_EQ(fromHalf(toHalf(1e9f)), 65504.0f);
    EXPECT_EQ(fromHalf(toHalf(-1e9f)), -65504.0f);
    EXPECT_EQ(fromHalf(toHalf(1e-6f)), 0.0f);
    EXPECT_EQ(fromHalf(toHalf(-1.0f)), -1.0f);
}

TEST(ShellLevels, NothingFoldsWhereCurvatureAllowsTheThickness) {
    const auto saddle = parametric(64, 64, false, false, [](double u, double v) {
        const double x = 2 * u - 1, y = 2 * v - 1;
        return Vec3d(x, y, 0.5 * (x * x - y * y)); // curvatures of 1 in the middle
    });
    ControlMesh ear = cube(ControlMesh::Scheme::CatmullClark);
    for (Vec3f& p : ear.points) {
        p.z *= 0.06f;
    }
    for (ControlMesh mesh : {sphere(48), torus(1, 0.4, 128, 64), saddle, ear}) {
        for (const float thickness : {0.1f, 0.3f}) { // times the largest curvature: 0.75, but in the ear
            Shell s;
            s.surface = refined(mesh, 0.1f);
            s.boundary = offsetInward(s.surface, thickness, {});
            s.map = analyticMap(
                s.surface, {1, 1}, [](const Vec3d& p) { return Vec2d(p.x, p.y); },
                [](const Vec3d&) { return Vec3d(1, 0, 0); }, [](const Vec3d&) { return Vec3d(0, 1, 0); });
            ShellGridOptions options;
            options.voxelSize = 0.025f;
            Messages messages;
            const ShellGrid grid = built(s, options, messages.sink());
            for (const ShellLevelReport& r : grid.levels()) {
                EXPECT_EQ(r.foldedVoxels, 0u) << thickness;
                EXPECT_EQ(r.missingShare, 0) << thickness;
            }
            EXPECT_FALSE(messages.has("folds over"));
        }
    }
}

// Perpendicular faces whose coordinates continue each other: depth and coordinate alone would not tell them apart.
TEST(ShellLevels, FacesAtAHardEdgeAreNotMixed) {
    Shell s;
    s.surface = refined(cube(ControlMesh::Scheme::None), 0.25f);
    ASSERT_FALSE(s.surface.cornerNormals.empty());
    s.boundary = offsetInward(s.surface, 0.2f, {});
    s.map = analyticMap(
        s.surface, {1, 1}, [](const Vec3d& p) { return Vec2d(p.x + p.y + p.z, p.x - p.y); },
        [](const Vec3d&) { return Vec3d(1, 1, 1); }, [](const Vec3d&) { return Vec3d(1, -1, 0); });
    ShellGridOptions options;
    options.voxelSize = 0.047f;
    const ShellGrid grid = built(s, options);
    ShellGrid::Accessor accessor(grid);
    Points points(27);
    for (int i = 0; i < 20000; ++i) {
        const double a = points.uniform(0.8, 1.0), b = points.uniform(0.8, 1.0);
        ShellLookup l;
        if (accessor.lookup(Vec3f(Vec3d(a, b, points.uniform(-0.5, 0.5))), l)) {
            EXPECT_GT(std::max(l.normal.x, l.normal.y), 0.9999f);
        }
    }
}

TEST(ShellLevels, EdgesWorthKnowingAreReported) {
    const auto reportOf = [](ControlMesh mesh, Messages& messages, ShellGridReport& report) {
        Shell s;
        s.surface = refined(std::move(mesh));
        s.boundary = offsetInward(s.surface, 0.05f, {});
        s.map = analyticMap(
            s.surface, {1, 1}, [](const Vec3d& p) { return Vec2d(p.x, p.y); },
            [](const Vec3d&) { return Vec3d(1, 0, 0); }, [](const Vec3d&) { return Vec3d(0, 1, 0); });
        ShellGridOptions options;
        options.voxelSize = 0.025f;
        report = built(s, options, messages.sink()).report();
    };
    Messages open, closed, mirrored, crowded;
    ShellGridReport r;
    reportOf(rectangle(1, 1, 4, 4), open, r);
    EXPECT_EQ(r.rimEdges, 16u);
    EXPECT_NEAR(r.rimLength, 4, 1e-6);
    EXPECT_FALSE(r.insideOut);

    reportOf(sphere(16), closed, r);
    EXPECT_EQ(r.rimEdges, 0u);
    EXPECT_FALSE(r.insideOut);
    EXPECT_FALSE(closed.has("inside out"));

    ControlMesh turned = sphere(16);
    turned.leftHanded = true;
    turned.normals.clear();
    reportOf(turned, mirrored, r);
    EXPECT_TRUE(r.insideOut);
    EXPECT_TRUE(mirrored.has("inside out"));

    // Three sheets that share an edge.
    ControlMesh fan;
    fan.scheme = ControlMesh::Scheme::None;
    fan.points = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0.5f, 0}, {-1, -0.5f, 0}};
    addFace(fan, {0, 1, 2});
    addFace(fan, {1, 0, 3});
    addFace(fan, {0, 1, 4});
    reportOf(fan, crowded, r);
    EXPECT_EQ(r.crowdedEdges, 1u);
    EXPECT_EQ(r.rimEdges, 6u);
    EXPECT_TRUE(crowded.has("more than two triangles"));
}
