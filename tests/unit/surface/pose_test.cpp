// SPDX-License-Identifier: Apache-2.0
// The rest pose decides how a surface is refined and sampled; the pose rides along. Tangent fields do so as well.
#include "stfLib/surface/refined_surface.h"
#include "stfLib/surface/split_edges.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

Vec3f bent(const Vec3f& p) {
    // Round the y axis with radius 3, so that a curve's length stays at z = 0.
    const float a = p.x / 3, r = 3 + p.z;
    return {r * std::sin(a), p.y + 0.1f * p.x, r * std::cos(a) - 3};
}

ControlMesh bentCube(ControlMesh::Scheme scheme) {
    ControlMesh mesh = cube(scheme);
    mesh.rest = mesh.points;
    for (Vec3f& p : mesh.points) {
        p = bent(p);
    }
    sanitize(mesh);
    return mesh;
}

void expectNear(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b, double tolerance) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        ASSERT_LE(double(length(a[i] - b[i])), tolerance) << i;
    }
}

class PoseOfScheme : public testing::TestWithParam<ControlMesh::Scheme> {};

TEST_P(PoseOfScheme, IsTheRefinedMeshItself) {
    const ControlMesh mesh = bentCube(GetParam());
    RefineOptions options;
    options.level = 3;
    options.targetEdge = GetParam() == ControlMesh::Scheme::None ? 0.2f : 0.0f;
    SurfacePose pose;
    const RefinedSurface rest = refineAtRest(mesh, options, {}, pose);
    ControlMesh atRest = mesh;
    atRest.points = mesh.rest;
    const RefinedSurface alone = refine(atRest, options, {});
    EXPECT_EQ(rest.triangles, alone.triangles);
    EXPECT_EQ(rest.points, alone.points) << "a pose has no say in the rest";
    EXPECT_EQ(rest.normals, alone.normals);
    // The mesh as it stands, refined by itself as often, has the same limit points and normals.
    const RefinedSurface posed = refine(mesh, options, {});
    if (GetParam() != ControlMesh::Scheme::None) { // whose bent quads may take another diagonal
        expectNear(pose.points, posed.points, 1e-6);
    } else {
        for (std::size_t i = 0; i < mesh.points.size(); ++i) {
            EXPECT_EQ(pose.points[i], mesh.points[i]);
        }
    }
    if (GetParam() == ControlMesh::Scheme::CatmullClark) {
        expectNear(pose.normals, posed.normals, 1e-5);
    }
    EXPECT_EQ(pose.cornerNormals.size(), rest.cornerNormals.size());
    const RefinedSurface seen = inPose(rest, pose);
    EXPECT_EQ(seen.points, pose.points);
    EXPECT_EQ(seen.triangles, rest.triangles);
    for (const Vec3f& p : seen.points) {
        Box3f box = seen.bounds;
        box.add(p);
        ASSERT_EQ(box.diagonal(), seen.bounds.diagonal());
    }
}

INSTANTIATE_TEST_SUITE_P(Schemes, PoseOfScheme,
                         testing::Values(ControlMesh::Scheme::None, ControlMesh::Scheme::CatmullClark,
                                         ControlMesh::Scheme::Bilinear));

TEST(Pose, SplitEdgesDependOnTheRestAlone) {
    RefineOptions options;
    options.level = 3;
    SurfacePose small, large;
    ControlMesh mesh = bentCube(ControlMesh::Scheme::CatmullClark);
    const RefinedSurface a = splitLongEdges(refineAtRest(mesh, options, {}, small), 0.05, 1000000, {}, &small);
    for (Vec3f& p : mesh.points) {
        p *= 7.0f;
    }
    const RefinedSurface unsplit = refineAtRest(mesh, options, {}, large);
    const std::size_t before = large.points.size();
    const RefinedSurface b = splitLongEdges(unsplit, 0.05, 1000000, {}, &large);
    ASSERT_GT(large.points.size(), 2 * before);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.points, b.points);
    ASSERT_EQ(large.points.size(), b.points.size());
    for (Vec3f& p : large.points) {
        p /= 7.0f;
    }
    expectNear(small.points, large.points, 1e-6);
    expectNear(small.normals, large.normals, 1e-5);
    // Middles lie on the arc: a posed sphere stays round.
    ControlMesh ball = sphere(6);
    ball.rest = ball.points;
    for (Vec3f& p : ball.rest) {
        p = {2 * p.x, p.y, p.z};
    }
    sanitize(ball);
    SurfacePose round;
    splitLongEdges(refineAtRest(ball, {}, {}, round), 0.1, 1000000, {}, &round);
    for (const Vec3f& p : round.points) {
        ASSERT_NEAR(length(p), 1, 2e-3);
    }
}

TEST(Pose, WhatIsNoRestPoseIsIgnored) {
    for (int flaw = 0; flaw < 3; ++flaw) {
        ControlMesh mesh = bentCube(ControlMesh::Scheme::CatmullClark);
        if (flaw == 0) {
            mesh.rest[3].y = std::nanf("");
        } else if (flaw == 1) {
            mesh.rest.pop_back();
        } else {
            mesh.rest.assign(8, Vec3f(1, 2, 3));
        }
        const MeshRepairs repairs = sanitize(mesh);
        EXPECT_TRUE(repairs.droppedRest);
        EXPECT_TRUE(mesh.rest.empty());
        EXPECT_NE(repairs.summary().find("stf:rest ignored"), std::string::npos);
        SurfacePose pose;
        EXPECT_THROW(refineAtRest(mesh, {}, {}, pose), Error);
    }
}

TEST(Orientation, OfAllInterpolationsArrivesAtTheLimitSurface) {
    using Interpolation = ControlMesh::Interpolation;
    for (const bool leftHanded : {false, true}) {
        for (const auto& [interpolation, count] :
             {std::pair(Interpolation::Constant, 1), std::pair(Interpolation::Uniform, 6),
              std::pair(Interpolation::Vertex, 8), std::pair(Interpolation::FaceVarying, 24)}) {
            ControlMesh mesh = cube(ControlMesh::Scheme::CatmullClark);
            mesh.leftHanded = leftHanded;
            mesh.orientation.assign(std::size_t(count), Vec3f(0, 0.1f, 0));
            mesh.orientationInterpolation = interpolation;
            sanitize(mesh);
            RefineOptions options;
            options.level = 2;
            RefinedSurface s = refine(mesh, options, {});
            s = splitLongEdges(std::move(s), 0.2, 100000, {});
            ASSERT_EQ(s.orientation.size(), s.points.size());
            for (const Vec3f& d : s.orientation) {
                ASSERT_NEAR(length(d - Vec3f(0, 1, 0)), 0, 1e-6);
            }
        }
    }
}

TEST(Orientation, ValuesPerFaceGoWithTheirFaces) {
    // Faces -z and +z ask for x, the others for nothing; a left-handed mesh turns its faces, not the field.
    for (const bool leftHanded : {false, true}) {
        ControlMesh mesh = cube(ControlMesh::Scheme::None);
        mesh.leftHanded = leftHanded;
        mesh.orientationInterpolation = ControlMesh::Interpolation::FaceVarying;
        mesh.orientation.assign(24, Vec3f());
        for (std::size_t i = 0; i < 8; ++i) {
            mesh.orientation[i] = {1, 0, 0};
        }
        mesh.faceVertexCounts.push_back(2); // is dropped, with its values
        mesh.faceVertexIndices.insert(mesh.faceVertexIndices.end(), {0, 1});
        mesh.orientation.insert(mesh.orientation.end(), 2, Vec3f(0, 0, 9));
        sanitize(mesh);
        RefineOptions options;
        options.targetEdge = 0.3f;
        const RefinedSurface s = refine(mesh, options, {});
        int wishes = 0, none = 0;
        for (std::size_t i = 0; i < s.points.size(); ++i) {
            if (std::abs(s.points[i].z) > 0.999f) {
                ASSERT_NEAR(length(s.orientation[i] - Vec3f(1, 0, 0)), 0, 1e-6);
                ++wishes;
            } else {
                none += length(s.orientation[i]) == 0;
            }
        }
        EXPECT_GT(wishes, 100);
        EXPECT_EQ(none, 0) << "between two faces that agree";
    }
}

TEST(Orientation, ZeroIsNoWishAndWhatIsBadIsNamed) {
    ControlMesh mesh = cube(ControlMesh::Scheme::CatmullClark);
    mesh.orientation.assign(8, Vec3f(1, 0, 0));
    for (std::size_t i = 0; i < 4; ++i) {
        mesh.orientation[i] = Vec3f();
    }
    mesh.orientation[7].x = std::nanf("");
    const MeshRepairs repairs = sanitize(mesh);
    EXPECT_EQ(repairs.nonFiniteOrientations, 1);
    EXPECT_NE(repairs.summary().find("1 vector of stf:orientation ignored"), std::string::npos) << repairs.summary();
    EXPECT_EQ(mesh.orientation[7], Vec3f());
    RefineOptions options;
    options.level = 3;
    const RefinedSurface s = refine(mesh, options, {});
    int none = 0;
    for (const Vec3f& d : s.orientation) {
        ASSERT_TRUE(length(d) == 0 || std::abs(length(d) - 1) < 1e-5f);
        none += length(d) == 0;
    }
    EXPECT_GT(none, int(s.points.size() / 5));
    EXPECT_LT(none, int(s.points.size() * 4 / 5));

    mesh = cube(ControlMesh::Scheme::CatmullClark);
    mesh.orientation.assign(5, Vec3f(1, 0, 0));
    EXPECT_NE(sanitize(mesh).summary().find("stf:orientation ignored (wrong count)"), std::string::npos);
    EXPECT_TRUE(mesh.orientation.empty());
}

} // namespace
