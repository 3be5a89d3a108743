// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/direction_field.h"

#include "stfLib/base/parallel.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

SurfaceGraph graphOf(ControlMesh mesh) {
    sanitize(mesh);
    return surfaceGraph(refine(mesh, {}, {}));
}

int indexSum(const std::vector<Singularity>& s) {
    int sum = 0;
    for (const Singularity& i : s) {
        sum += i.index;
    }
    return sum;
}

std::vector<Vec3f> solve(const SurfaceGraph& g, const std::vector<Vec3f>& guide = {}) {
    Progress progress;
    return smoothDirections(g, guide, progress);
}

} // namespace

TEST(DirectionField, IsUnitAndTangent) {
    const SurfaceGraph g = graphOf(sphere(20));
    const std::vector<Vec3f> d = solve(g);
    for (std::size_t v = 0; v < g.size(); ++v) {
        EXPECT_NEAR(length(d[v]), 1, 1e-5);
        EXPECT_NEAR(dot(d[v], g.normals[v]), 0, 1e-5);
    }
}

TEST(DirectionField, ASphereHasTwoSingularities) {
    // 9602 vertices: more than the level that is factored.
    const SurfaceGraph g = graphOf(sphere(40));
    const std::vector<Singularity> s = singularities(g, solve(g));
    EXPECT_EQ(indexSum(s), 2);
    EXPECT_EQ(s.size(), 2u);
}

TEST(DirectionField, ATorusHasNone) {
    const SurfaceGraph g = graphOf(torus(3, 1, 96, 64));
    EXPECT_TRUE(singularities(g, solve(g)).empty());
}

TEST(DirectionField, IsUniformOnACylinder) {
    const SurfaceGraph g = graphOf(cylinder(1, 3, 120, 60));
    const std::vector<Vec3f> d = solve(g);
    EXPECT_TRUE(singularities(g, d).empty());
    // The same angle to the axis everywhere, up to what lone iterations leave.
    double sum = 0, square = 0;
    for (const Vec3f& t : d) {
        sum += double(t.z);
        square += double(t.z) * double(t.z);
    }
    const double mean = sum / double(d.size());
    EXPECT_LT(square / double(d.size()) - mean * mean, 1e-4);
}

TEST(DirectionField, FollowsAGuideAndFillsTheRest) {
    const SurfaceGraph g = graphOf(rectangle(2, 2, 40, 40));
    std::vector<Vec3f> guide(g.size());
    const Vec3f wanted = normalize(Vec3f(1, 2, 0));
    for (std::size_t v = 0; v < g.size(); ++v) {
        guide[v] = g.points[v].x < 0.2f ? wanted * 3.0f : Vec3f();
    }
    for (const Vec3f& d : solve(g, guide)) {
        EXPECT_GT(dot(d, wanted), 0.999f);
    }
}

TEST(DirectionField, DoesNotDependOnThreads) {
    const SurfaceGraph g = graphOf(sphere(40));
    setThreadCount(1);
    const std::vector<Vec3f> one = solve(g);
    setThreadCount(4);
    const std::vector<Vec3f> four = solve(g);
    setThreadCount(0);
    EXPECT_EQ(one, four);
}

TEST(DirectionField, SeparatePartsEachGetAField) {
    ControlMesh two = sphere(12);
    const ControlMesh other = sphere(12);
    const int n = int(two.points.size());
    for (const Vec3f& p : other.points) {
        two.points.push_back(p + Vec3f(5, 0, 0));
    }
    two.normals.insert(two.normals.end(), other.normals.begin(), other.normals.end());
    for (int i : other.faceVertexIndices) {
        two.faceVertexIndices.push_back(i + n);
    }
    two.faceVertexCounts.insert(two.faceVertexCounts.end(), other.faceVertexCounts.begin(),
                                other.faceVertexCounts.end());
    const SurfaceGraph g = graphOf(two);
    EXPECT_EQ(indexSum(singularities(g, solve(g))), 4);
}

TEST(DirectionField, RefusesAGuideOfAnotherMesh) {
    const SurfaceGraph g = graphOf(rectangle(1, 1, 2, 2));
    EXPECT_THROW(solve(g, std::vector<Vec3f>(3)), Error);
}
