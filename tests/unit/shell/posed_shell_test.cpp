// SPDX-License-Identifier: Apache-2.0
// A plate that is bent to a part of a cylinder: where its points were at rest is known in closed form.
#include "stfLib/base/random.h"
#include "stfLib/shell/posed_shell.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

constexpr double kWidth = 4, kHeight = 2;
constexpr float kThickness = 0.2f;

/// A plate in z = 0 bent about the y axis: convex for a positive radius. Lengths at its surface stay.
struct Bend {
    double radius;
    Vec3d operator()(const Vec3d& p) const {
        const double a = (p.x - 0.5 * kWidth) / radius, r = radius + p.z;
        return {r * std::sin(a), p.y, r * std::cos(a) - radius};
    }
    /// The plate's x, y and z of a posed point.
    Vec3d inverse(const Vec3d& p) const {
        const double side = radius > 0 ? 1 : -1;
        const double a = std::atan2(side * p.x, side * (p.z + radius)), r = side * std::hypot(p.x, p.z + radius);
        return {a * radius + 0.5 * kWidth, p.y, r - radius};
    }
    Vec3d normal(double x) const {
        const double a = (x - 0.5 * kWidth) / radius;
        return {std::sin(a), 0, std::cos(a)};
    }
};

struct Plate {
    std::shared_ptr<const RefinedSurface> rest, posed;
    std::shared_ptr<const ShellBoundary> restBoundary, posedBoundary;
    ShellGrid grid;
    std::unique_ptr<PosedShell> pose;
};

RefinedSurface plateSurface(double edge, SurfacePose& pose, const Bend& bend) {
    ControlMesh mesh = rectangle(kWidth, kHeight, int(kWidth / edge), int(kHeight / edge));
    mesh.rest = mesh.points;
    mesh.normalInterpolation = ControlMesh::Interpolation::Vertex;
    for (Vec3f& p : mesh.points) {
        mesh.normals.push_back(Vec3f(bend.normal(double(p.x))));
        p = Vec3f(bend(Vec3d(p)));
    }
    sanitize(mesh);
    return refineAtRest(mesh, {}, {}, pose);
}

/// Tile millimetres are the plate's units.
ExemplarMap plateMap(const RefinedSurface& rest, const RefinedSurface& seen, const Bend* bend) {
    ExemplarMap map;
    map.tileMm = {1, 1};
    for (const Vec3i& t : rest.triangles) {
        for (int c = 0; c < 3; ++c) {
            const Vec3d p(rest.points[std::size_t(t[c])]), n(seen.normals[std::size_t(t[c])]);
            map.cornerCoords.push_back({float(p.x), float(p.y)});
            map.gradientX.push_back(bend ? Vec3f(cross(Vec3d(0, 1, 0), n)) : Vec3f(1, 0, 0));
            map.gradientY.push_back({0, 1, 0});
        }
    }
    return map;
}

ShellGrid gridOf(const RefinedSurface& s, const ShellBoundary& b, const ExemplarMap& map) {
    ShellGridOptions options;
    options.voxelSize = 0.25f * kThickness;
    Progress progress;
    return ShellGrid::build(s, b, map, options, progress, {});
}

Plate plate(const Bend& bend, double edge) {
    Plate p;
    SurfacePose pose;
    p.rest = std::make_shared<const RefinedSurface>(plateSurface(edge, pose, bend));
    p.posed = std::make_shared<const RefinedSurface>(inPose(*p.rest, pose));
    p.restBoundary = std::make_shared<const ShellBoundary>(offsetInward(*p.rest, kThickness, {}));
    p.posedBoundary = std::make_shared<const ShellBoundary>(offsetPosed(*p.posed, kThickness, *p.restBoundary));
    p.grid = gridOf(*p.rest, *p.restBoundary, plateMap(*p.rest, *p.rest, nullptr));
    p.pose = std::make_unique<PosedShell>(
        PosedShell::Shape{p.rest, p.restBoundary}, PosedShell::Shape{p.posed, p.posedBoundary},
        std::make_shared<const PosedShell::Neighbours>(PosedShell::neighboursOf(*p.rest)));
    return p;
}

double nearestImage(double d) {
    return d - std::nearbyint(d);
}

struct Differences {
    double exemplar = 0, depth = 0, gradient = 0, normal = 0;
    int points = 0, missed = 0;
};

/// Asks for points along straight rays through the bent shell, as the march does, each from where the ray entered.
template<class Compare>
Differences along(const Plate& p, const Bend& bend, const Compare& compare) {
    CounterRng rng(1, 2);
    Differences d;
    ShellProbe probe(p.grid, *p.rest, p.pose.get());
    for (int ray = 0; ray < 400; ++ray) {
        const std::uint32_t t = std::uint32_t(double(rng.uniform()) * double(p.rest->triangles.size()));
        Vec3d entry;
        for (int c = 0; c < 3; ++c) {
            entry += Vec3d(p.posed->points[std::size_t(p.posed->triangles[t][c])]) / 3;
        }
        Vec3d in = normalize(Vec3d(double(rng.uniform()) - 0.5, double(rng.uniform()) - 0.5, -0.6));
        probe.enter(t);
        for (double s = 0.01; s < 3; s += 0.04) {
            const Vec3d at = entry + in * s, rest = bend.inverse(at);
            if (rest.z > 0 || rest.z < -0.98 * double(kThickness) || rest.x < 0.1 || rest.x > kWidth - 0.1 ||
                rest.y < 0.1 || rest.y > kHeight - 0.1) {
                break;
            }
            ++d.points;
            ShellLookup l{};
            if (!probe.lookup(Vec3f(at), l)) {
                ++d.missed;
                continue;
            }
            compare(at, rest, l, d);
        }
    }
    EXPECT_GT(d.points, 1500);
    return d;
}

class BentPlate : public testing::TestWithParam<double> {};

TEST_P(BentPlate, PointsKnowWhereTheyWereAtRest) {
    const Bend bend{GetParam()};
    const Plate p = plate(bend, 0.05);
    const Differences d = along(p, bend, [&](const Vec3d&, const Vec3d& rest, const ShellLookup& l, Differences& out) {
        out.exemplar = std::max({out.exemplar, std::abs(nearestImage(double(l.exemplar.x) - rest.x)),
                                 std::abs(nearestImage(double(l.exemplar.y) - rest.y))});
        out.depth = std::max(out.depth, std::abs(double(l.depth) + rest.z));
        out.normal = std::max(out.normal, double(length(Vec3d(l.normal) - bend.normal(rest.x))));
        // Deeper layers of a convex bend are shorter: as much of the sample on less way.
        const Vec3d gradient = cross(Vec3d(0, 1, 0), bend.normal(rest.x)) * (bend.radius / (bend.radius + rest.z));
        out.gradient = std::max(out.gradient, length(Vec3d(l.gradX) - gradient));
    });
    // Facets of 0.05 lie up to edge^2 / 8 r below the arc.
    const double facet = 0.05 * 0.05 / 8 / std::abs(bend.radius);
    EXPECT_EQ(d.missed, 0);
    EXPECT_LT(d.exemplar, 3 * facet);
    EXPECT_LT(d.depth, 3 * facet);
    EXPECT_LT(d.normal, 1e-3);
    EXPECT_LT(d.gradient, 0.05 / std::abs(bend.radius));
}

TEST_P(BentPlate, EqualsAGridInThePose) {
    const Bend bend{GetParam()};
    const Plate p = plate(bend, 0.05);
    const ShellGrid there = gridOf(*p.posed, *p.posedBoundary, plateMap(*p.rest, *p.posed, &bend));
    ShellGrid::Accessor accessor(there);
    double squares = 0;
    const Differences d = along(p, bend, [&](const Vec3d& at, const Vec3d&, const ShellLookup& l, Differences& out) {
        ShellLookup other{};
        ASSERT_TRUE(accessor.lookup(Vec3f(at), other));
        const double x = nearestImage(double(l.exemplar.x - other.exemplar.x)),
                     y = nearestImage(double(l.exemplar.y - other.exemplar.y));
        squares += x * x + y * y;
        out.exemplar = std::max(out.exemplar, std::hypot(x, y));
        out.depth = std::max(out.depth, double(std::abs(l.depth - other.depth)));
        out.gradient = std::max(out.gradient, double(length(l.gradX - other.gradX)));
        out.normal = std::max(out.normal, double(length(l.normal - other.normal)));
    });
    const double voxel = 0.25 * double(kThickness);
    RecordProperty("rms_voxels", std::to_string(std::sqrt(squares / d.points) / voxel));
    RecordProperty("largest_voxels", std::to_string(d.exemplar / voxel));
    RecordProperty("depth_voxels", std::to_string(d.depth / voxel));
    EXPECT_EQ(d.missed, 0);
    EXPECT_LT(std::sqrt(squares / d.points), 0.02 * voxel);
    EXPECT_LT(d.exemplar, 0.1 * voxel);
    EXPECT_LT(d.depth, 0.1 * voxel);
    EXPECT_LT(d.gradient, 0.1);
    EXPECT_LT(d.normal, 0.03);
}

// At a thickness of 0.2: from gentle to nearly a ring.
INSTANTIATE_TEST_SUITE_P(Radii, BentPlate, testing::Values(20.0, 4.0, 1.0, 0.7, -20.0, -4.0, -1.0));

TEST(PosedShell, AtRestNothingChanges) {
    const Bend bend{1e9};
    const Plate p = plate(bend, 0.1);
    ShellProbe probe(p.grid, *p.rest, p.pose.get());
    ShellGrid::Accessor accessor(p.grid);
    CounterRng rng(3, 4);
    probe.enter(0);
    for (int i = 0; i < 2000; ++i) {
        const Vec3f at(float(0.1 + 3.8 * double(rng.uniform())), float(0.1 + 1.8 * double(rng.uniform())),
                       -kThickness * rng.uniform());
        ShellLookup a{}, b{};
        // Posed points are shifted by half the width: the bend's middle is at 0.
        ASSERT_TRUE(probe.lookup(at - Vec3f(float(0.5 * kWidth), 0, 0), a)) << i;
        ASSERT_TRUE(accessor.lookup(at, b));
        EXPECT_NEAR(nearestImage(double(a.exemplar.x - b.exemplar.x)), 0, 1e-4);
        EXPECT_NEAR(a.depth, b.depth, 1e-4);
        EXPECT_NEAR(length(a.gradX - b.gradX), 0, 1e-4);
    }
}

TEST(PosedShell, OutsideThereIsNothing) {
    const Bend bend{4};
    const Plate p = plate(bend, 0.1);
    ShellProbe probe(p.grid, *p.rest, p.pose.get());
    ShellLookup l{};
    probe.enter(10);
    EXPECT_FALSE(probe.lookup({0, 1, 5}, l)) << "above";
    EXPECT_FALSE(probe.lookup({0, 1, -2}, l)) << "below";
    EXPECT_FALSE(probe.lookup(Vec3f(bend({-0.5, 1, -0.1})), l)) << "beyond the rim";
    EXPECT_FALSE(probe.lookup(Vec3f(std::nanf("")), l));
    EXPECT_TRUE(probe.lookup(Vec3f(bend({2, 1, -0.1})), l)) << "found again afterwards";
}

TEST(PosedShell, IsNowhereDeeperThanAtRest) {
    const Bend bend{4};
    const Plate p = plate(bend, 0.1);
    ShellBoundary rest = *p.restBoundary;
    rest.thickness[7] = 0.05f;
    const ShellBoundary b = offsetPosed(*p.posed, kThickness, rest);
    EXPECT_FLOAT_EQ(b.thickness[7], 0.05f);
    EXPECT_NEAR(length(p.posed->points[7] - b.inner[7]), 0.05, 1e-5);
    EXPECT_FLOAT_EQ(b.thickness[8], kThickness);
    // A concave bend beyond its focus is thinner than at rest.
    const Plate tight = plate(Bend{-0.15}, 0.02);
    EXPECT_LE(*std::max_element(tight.posedBoundary->thickness.begin(), tight.posedBoundary->thickness.end()),
              kThickness);
    rest.thickness.pop_back();
    EXPECT_THROW(offsetPosed(*p.posed, kThickness, rest), Error);
}

TEST(PosedShell, NeighboursReachAcrossCutsAndEndAtRims) {
    // Two triangles of a square whose shared points are doubled, and a third that hangs on an edge of both.
    RefinedSurface s;
    s.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    s.normals.assign(6, {0, 0, 1});
    s.triangles = {{0, 1, 2}, {3, 4, 5}};
    PosedShell::Neighbours n = PosedShell::neighboursOf(s);
    EXPECT_EQ(n[0], Vec3i(-1, -1, 1));
    EXPECT_EQ(n[1], Vec3i(0, -1, -1));
    s.points.push_back({1, 0, 1});
    s.normals.push_back({0, 0, 1});
    s.triangles.push_back({0, 2, 6});
    n = PosedShell::neighboursOf(s);
    EXPECT_EQ(n[0], Vec3i(-1)) << "where three meet there is no one way";
    EXPECT_EQ(n[2], Vec3i(-1));
}

TEST(PosedShell, OtherTrianglesAreNoPose) {
    const Plate a = plate(Bend{4}, 0.1), b = plate(Bend{4}, 0.2);
    EXPECT_THROW(PosedShell({a.rest, a.restBoundary}, {b.posed, b.posedBoundary},
                            std::make_shared<const PosedShell::Neighbours>(PosedShell::neighboursOf(*a.rest))),
                 Error);
}

} // namespace
