// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/refined_surface.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>
#include <map>

using namespace stf;
using namespace stf::test;

namespace {

RefinedSurface refined(ControlMesh mesh, int level, float targetEdge = 0) {
    sanitize(mesh);
    RefineOptions options;
    options.level = level;
    options.targetEdge = targetEdge;
    return refine(mesh, options, {});
}

/// The point nearest to `p`.
std::size_t nearest(const RefinedSurface& s, const Vec3f& p) {
    std::size_t best = 0;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        if (length(s.points[i] - p) < length(s.points[best] - p)) {
            best = i;
        }
    }
    return best;
}

double volume(const RefinedSurface& s) {
    double v = 0;
    for (const Vec3i& t : s.triangles) {
        v += dot(Vec3d(s.points[std::size_t(t.x)]),
                 cross(Vec3d(s.points[std::size_t(t.y)]), Vec3d(s.points[std::size_t(t.z)]))) /
             6;
    }
    return v;
}

double area(const RefinedSurface& s) {
    double a = 0;
    for (const Vec3i& t : s.triangles) {
        const Vec3d p(s.points[std::size_t(t.x)]);
        a += 0.5 * length(cross(Vec3d(s.points[std::size_t(t.y)]) - p, Vec3d(s.points[std::size_t(t.z)]) - p));
    }
    return a;
}

/// Every edge of a closed surface is used once in each direction: no crack, one orientation.
bool closedAndOriented(const RefinedSurface& s) {
    std::map<std::pair<int, int>, int> edges;
    for (const Vec3i& t : s.triangles) {
        for (int c = 0; c < 3; ++c) {
            ++edges[{t[c], t[(c + 1) % 3]}];
        }
    }
    for (const auto& [e, n] : edges) {
        const auto back = edges.find({e.second, e.first});
        if (n != 1 || back == edges.end() || back->second != 1) {
            return false;
        }
    }
    return true;
}

} // namespace

// The limit of a cube's corner is (9 v + 4 sum of edge neighbours + sum of face diagonals) / 24 = 1/2 (Halstead et al.
// 1993, valence 3); of a face's centre, by the same mask after one refinement, 0.839506.
TEST(Refine, CatmullClarkCubeHasItsKnownLimit) {
    for (int level = 1; level <= 4; ++level) {
        const RefinedSurface s = refined(cube(ControlMesh::Scheme::CatmullClark), level);
        const std::size_t corner = nearest(s, {0.5f, 0.5f, 0.5f}), face = nearest(s, {0, 0, 1});
        EXPECT_NEAR(length(s.points[corner] - Vec3f(0.5f)), 0, 1e-6);
        EXPECT_NEAR(s.points[face].z, (16 + 12 + 20.0 / 9) / 36, 1e-6);
        EXPECT_NEAR(dot(s.normals[corner], normalize(Vec3f(1))), 1, 1e-6);
        EXPECT_NEAR(s.normals[face].z, 1, 1e-6);
        EXPECT_EQ(s.triangles.size(), std::size_t(12) << (2 * level));
        EXPECT_TRUE(closedAndOriented(s));
        EXPECT_GT(volume(s), 0);
    }
}

// Limit points of coarse levels are points of the same surface as those of fine ones.
TEST(Refine, LimitDoesNotDependOnTheLevel) {
    const RefinedSurface coarse = refined(cube(ControlMesh::Scheme::CatmullClark), 2);
    const RefinedSurface fine = refined(cube(ControlMesh::Scheme::CatmullClark), 5);
    for (std::size_t i = 0; i < coarse.points.size(); ++i) {
        const std::size_t k = nearest(fine, coarse.points[i]);
        EXPECT_LT(length(fine.points[k] - coarse.points[i]), 2e-6f);
        EXPECT_LT(length(fine.normals[k] - coarse.normals[i]), 2e-5f);
    }
}

// Loop's limit mask: w v + sum of neighbours over w + n, w = 3 / (8 beta), beta(4) = 31/256: 96/220.
TEST(Refine, LoopOctahedronHasItsKnownLimit) {
    const RefinedSurface s = refined(octahedron(), 3);
    const std::size_t top = nearest(s, {0, 0, 1});
    EXPECT_NEAR(s.points[top].z, 96.0 / 220, 1e-6);
    EXPECT_NEAR(s.normals[top].z, 1, 1e-6);
    EXPECT_TRUE(closedAndOriented(s));
    EXPECT_GT(volume(s), 0);
}

TEST(Refine, LoopOverQuadsFallsBackWithAMessage) {
    Messages messages;
    ControlMesh mesh = cube(ControlMesh::Scheme::Loop);
    sanitize(mesh);
    RefineOptions options;
    options.level = 1;
    const RefinedSurface s = refine(mesh, options, messages.sink());
    EXPECT_TRUE(messages.has("loop needs triangles"));
    EXPECT_NEAR(length(s.points[nearest(s, Vec3f(0.5f))] - Vec3f(0.5f)), 0, 1e-6);
}

TEST(Refine, LeftHandedMeshesAreTurned) {
    for (ControlMesh::Scheme scheme : {ControlMesh::Scheme::CatmullClark, ControlMesh::Scheme::None}) {
        ControlMesh mesh = cube(scheme);
        std::size_t begin = 0;
        for (int n : mesh.faceVertexCounts) {
            std::reverse(mesh.faceVertexIndices.begin() + std::ptrdiff_t(begin),
                         mesh.faceVertexIndices.begin() + std::ptrdiff_t(begin) + n);
            begin += std::size_t(n);
        }
        mesh.leftHanded = true;
        const RefinedSurface s = refined(mesh, 1);
        EXPECT_GT(volume(s), 0);
        const std::size_t top = nearest(s, {0, 0, 1});
        EXPECT_GT(s.normals[top].z, 0);
    }
}

TEST(Refine, InfinitelySharpCreasesKeepTheCube) {
    ControlMesh mesh = cube(ControlMesh::Scheme::CatmullClark);
    for (int a = 0; a < 8; ++a) {
        for (int bit : {1, 2, 4}) {
            if (!(a & bit)) {
                mesh.creaseIndices.insert(mesh.creaseIndices.end(), {a, a | bit});
                mesh.creaseLengths.push_back(2);
                mesh.creaseSharpnesses.push_back(10);
            }
        }
    }
    const RefinedSurface s = refined(mesh, 3);
    EXPECT_NEAR(volume(s), 8, 1e-5);
    EXPECT_NEAR(area(s), 24, 1e-4);
    EXPECT_NEAR(dot(s.normals[nearest(s, Vec3f(1))], normalize(Vec3f(1))), 1, 1e-5);
}

TEST(Refine, BoundaryRulesAreThoseOfUsd) {
    ControlMesh mesh = rectangle(1, 1, 4, 4);
    mesh.scheme = ControlMesh::Scheme::CatmullClark;
    mesh.interpolateBoundary = "edgeAndCorner";
    EXPECT_NEAR(area(refined(mesh, 3)), 1, 1e-5);
    mesh.interpolateBoundary = "edgeOnly";
    EXPECT_LT(area(refined(mesh, 3)), 0.999);
    mesh.interpolateBoundary = "none"; // the outer ring of faces goes
    EXPECT_NEAR(area(refined(mesh, 3)), 0.25, 1e-5);
}

TEST(Refine, HolesHaveNoTriangles) {
    for (ControlMesh::Scheme scheme : {ControlMesh::Scheme::CatmullClark, ControlMesh::Scheme::None}) {
        ControlMesh mesh = rectangle(3, 1, 3, 1);
        mesh.scheme = scheme;
        mesh.holeIndices = {1};
        const RefinedSurface s = refined(mesh, 2);
        EXPECT_NEAR(area(s), 2, 1e-5);
        for (int f : s.triangleFace) {
            EXPECT_NE(f, 1);
        }
    }
}

TEST(Refine, UvAreSubdividedWithTheSurfaceAndCutAtSeams) {
    ControlMesh mesh = cylinder(1, 2, 8, 4);
    mesh.scheme = ControlMesh::Scheme::CatmullClark;
    const RefinedSurface s = refined(mesh, 3);
    ASSERT_EQ(s.uvTriangles.size(), s.triangles.size());
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const Vec3f p = s.points[std::size_t(s.triangles[t][c])];
            const Vec2f uv = s.uvs[std::size_t(s.uvTriangles[t][c])];
            // Angle and u agree up to the curve's own parametrisation, which stays within a fifth of a control edge.
            const double angle = std::atan2(double(p.y), double(p.x)) / (2 * pi);
            const double difference = double(uv.x) - angle;
            EXPECT_LT(std::abs(difference - std::round(difference)), 0.025);
            EXPECT_GE(uv.x, -1e-6f);
            EXPECT_LE(uv.x, 1 + 1e-6f);
            EXPECT_LT(std::abs(uv.x - s.uvs[std::size_t(s.uvTriangles[t][(c + 1) % 3])].x), 0.1f);
        }
    }
}

// Face-varying data without indices: values equal at a point belong together.
TEST(Refine, UnindexedUvAreWelded) {
    ControlMesh mesh = rectangle(1, 1, 4, 4);
    mesh.scheme = ControlMesh::Scheme::CatmullClark;
    const RefinedSurface indexed = refined(mesh, 2);
    std::vector<Vec2f> flat;
    for (int i : mesh.uvIndices) {
        flat.push_back(mesh.uvs[std::size_t(i)]);
    }
    mesh.uvs = flat;
    for (std::size_t i = 0; i < mesh.uvIndices.size(); ++i) {
        mesh.uvIndices[i] = int(i);
    }
    const RefinedSurface welded = refined(mesh, 2);
    EXPECT_EQ(welded.uvs.size(), indexed.uvs.size());
}

TEST(Refine, NonManifoldMeshesAreReportedAndSurvive) {
    ControlMesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {5, 5, 5}};
    addFace(mesh, {0, 1, 2});
    addFace(mesh, {1, 0, 3});
    addFace(mesh, {0, 1, 4});
    for (ControlMesh::Scheme scheme :
         {ControlMesh::Scheme::CatmullClark, ControlMesh::Scheme::Loop, ControlMesh::Scheme::Bilinear}) {
        mesh.scheme = scheme;
        Messages messages;
        RefineOptions options;
        options.level = 2;
        sanitize(mesh);
        const RefinedSurface s = refine(mesh, options, messages.sink());
        EXPECT_TRUE(messages.has("more than two faces"));
        for (std::size_t i = 0; i < s.points.size(); ++i) {
            EXPECT_TRUE(isFinite(s.points[i]));
            EXPECT_NEAR(length(s.normals[i]), 1, 1e-4);
        }
        EXPECT_LT(s.bounds.hi.x, 2) << "an unused point is no part of the surface";
    }
}

TEST(Refine, TargetEdgeChoosesTheLevelAndTrianglesAreBounded) {
    const auto longest = [](const RefinedSurface& s) {
        float l = 0;
        for (const Vec3i& t : s.triangles) {
            for (int c = 0; c < 3; ++c) {
                l = std::max(l, length(s.points[std::size_t(t[c])] - s.points[std::size_t(t[(c + 1) % 3])]));
            }
        }
        return l;
    };
    const RefinedSurface smooth = refined(cube(ControlMesh::Scheme::CatmullClark), 0, 0.1f);
    EXPECT_LT(longest(smooth), 0.1f * 1.6f); // diagonals and the few edges above the percentile
    EXPECT_GT(longest(smooth), 0.04f);
    const RefinedSurface flat = refined(cube(ControlMesh::Scheme::None), 0, 0.1f);
    EXPECT_LE(longest(flat), 0.1f);
    EXPECT_GT(longest(flat), 0.05f);
    EXPECT_TRUE(closedAndOriented(flat));
    EXPECT_NEAR(volume(flat), 8, 1e-5);

    for (ControlMesh::Scheme scheme : {ControlMesh::Scheme::CatmullClark, ControlMesh::Scheme::None}) {
        Messages messages;
        RefineOptions options;
        options.targetEdge = 1e-4f;
        options.maxTriangles = 1000;
        const RefinedSurface s = refine(cube(scheme), options, messages.sink());
        EXPECT_LE(s.triangles.size(), 1000u);
        EXPECT_GE(s.triangles.size(), 250u);
        EXPECT_TRUE(messages.has("instead of"));
    }
}

TEST(Refine, WhatOnlyTheEdgeAsksForHasABoundOfItsOwn) {
    Messages messages;
    RefineOptions options;
    options.targetEdge = 1e-4f;
    options.maxEdgeTriangles = 1000;
    const ControlMesh mesh = cube(ControlMesh::Scheme::CatmullClark);
    const std::size_t within = refine(mesh, options, messages.sink()).triangles.size();
    EXPECT_LE(within, 1000u);
    EXPECT_GT(4 * within, 1000u);
    options.level = 5; // asked for: 12 * 4^5 triangles
    EXPECT_EQ(refine(mesh, options, messages.sink()).triangles.size(), 12288u);
    EXPECT_EQ(messages.text, "");
}

TEST(Refine, PolygonsAreFacetedUnlessNormalsAreAuthored) {
    const RefinedSurface s = refined(cube(ControlMesh::Scheme::None), 0, 0.6f);
    ASSERT_EQ(s.cornerNormals.size(), 3 * s.triangles.size());
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        const Vec3f p = s.points[std::size_t(s.triangles[t].x)];
        const Vec3f facet =
            normalize(cross(s.points[std::size_t(s.triangles[t].y)] - p, s.points[std::size_t(s.triangles[t].z)] - p));
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(dot(facet, s.cornerNormals[3 * t + c]), 1, 1e-5);
        }
    }
    // Angle-weighted: independent of the diagonals, the corner's normal is the cube's diagonal.
    EXPECT_NEAR(dot(s.normals[nearest(s, Vec3f(1))], normalize(Vec3f(1))), 1, 1e-6);

    const RefinedSurface ball = refined(sphere(8), 0);
    EXPECT_TRUE(ball.cornerNormals.empty());
    for (std::size_t i = 0; i < ball.points.size(); ++i) {
        EXPECT_NEAR(length(ball.normals[i] - ball.points[i]), 0, 1e-5);
    }
}

// What nobody needs is not made, all else is the same; over more faces than one thread takes at a time, with holes.
TEST(Refine, WithoutNormalsOfPointsFacesHaveTheirs) {
    ControlMesh mesh = rectangle(1, 1, 120, 80);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        mesh.points[i].z += 0.01f * float(i * i % 7);
    }
    mesh.points.push_back({5, 5, 5}); // of no face
    const int n = int(mesh.points.size()) - 1;
    addFace(mesh, {0, n, 1});
    mesh.uvs.clear();
    mesh.uvIndices.clear();
    mesh.scheme = ControlMesh::Scheme::None;
    mesh.holeIndices = {3, 4095, 4096, 9000};
    for (const bool leftHanded : {false, true}) {
        mesh.leftHanded = leftHanded;
        ControlMesh given = mesh;
        EXPECT_EQ(sanitize(given).summary(), "");
        RefineOptions options;
        const RefinedSurface full = refine(given, options, {});
        options.pointNormals = false;
        const RefinedSurface lean = refine(given, options, {});
        EXPECT_EQ(lean.triangles.size(), 2u * (120 * 80 - 4) + 1);
        EXPECT_EQ(lean.points, full.points);
        EXPECT_EQ(lean.triangles, full.triangles);
        EXPECT_EQ(lean.triangleFace, full.triangleFace);
        EXPECT_TRUE(lean.normals.empty() && lean.cornerNormals.empty());
        ASSERT_EQ(full.cornerNormals.size(), 3 * full.triangles.size());
        for (std::size_t t = 0; t < lean.triangles.size(); ++t) {
            for (std::size_t c = 0; c < 3; ++c) {
                ASSERT_EQ(lean.faceNormals[std::size_t(lean.triangleFace[t])], full.cornerNormals[3 * t + c]);
            }
        }
        // Authored normals are used all the same.
        given.normals.assign(1, normalize(Vec3f(0.1f, 0.1f, leftHanded ? -1 : 1)));
        given.normalInterpolation = ControlMesh::Interpolation::Constant;
        const RefinedSurface shaded = refine(given, options, {});
        EXPECT_TRUE(shaded.faceNormals.empty());
        EXPECT_EQ(shaded.normals.size(), shaded.points.size());
    }
}

TEST(Refine, ConcavePolygonsAreCoveredOnce) {
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    // A comb: concave, with collinear corners.
    mesh.points = {{0, 0, 0}, {5, 0, 0}, {5, 3, 0}, {4, 3, 0}, {4, 1, 0}, {3, 1, 0},
                   {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
    mesh.faceVertexCounts = {12};
    for (int i = 0; i < 12; ++i) {
        mesh.faceVertexIndices.push_back(i);
    }
    addFace(mesh, {12, 13, 14, 15}); // an arrow head
    mesh.points.insert(mesh.points.end(), {{0, 0, 1}, {2, 2, 1}, {0, 1, 1}, {-2, 2, 1}});
    const RefinedSurface s = refined(mesh, 0);
    EXPECT_EQ(s.triangles.size(), 12u);
    EXPECT_NEAR(area(s), 11 + 2, 1e-5);
    for (const Vec3i& t : s.triangles) {
        const Vec3f p = s.points[std::size_t(t.x)];
        EXPECT_GE(cross(s.points[std::size_t(t.y)] - p, s.points[std::size_t(t.z)] - p).z, 0);
    }
}

TEST(Refine, ColorsOfEveryInterpolationBecomeOnePerPoint) {
    using Interpolation = ControlMesh::Interpolation;
    for (ControlMesh::Scheme scheme : {ControlMesh::Scheme::CatmullClark, ControlMesh::Scheme::None}) {
        for (Interpolation i :
             {Interpolation::Constant, Interpolation::Uniform, Interpolation::Vertex, Interpolation::FaceVarying}) {
            ControlMesh mesh = cube(scheme);
            mesh.colorInterpolation = i;
            mesh.colors.assign(i == Interpolation::Constant  ? 1
                               : i == Interpolation::Uniform ? 6
                               : i == Interpolation::Vertex  ? 8
                                                             : 24,
                               Rgb(0.25f, 0.5f, 0.75f));
            const RefinedSurface s = refined(mesh, 1, 0.8f);
            ASSERT_EQ(s.colors.size(), s.points.size());
            for (const Rgb& c : s.colors) {
                EXPECT_NEAR(length(c - Rgb(0.25f, 0.5f, 0.75f)), 0, 1e-6);
            }
        }
    }
    EXPECT_TRUE(refined(cube(ControlMesh::Scheme::None), 0).colors.empty());
}

TEST(Refine, OneTriangleAndFarAwayMeshesWork) {
    ControlMesh mesh;
    mesh.points = {{1e6f, 0, 0}, {1e6f + 1, 0, 0}, {1e6f, 1, 0}};
    addFace(mesh, {0, 1, 2});
    for (int scheme = 0; scheme < 4; ++scheme) {
        mesh.scheme = ControlMesh::Scheme(scheme);
        const RefinedSurface s = refined(mesh, 2, 0.2f);
        EXPECT_NEAR(s.normals[0].z, 1, 1e-5);
        EXPECT_GT(area(s), 0.3);
    }
}

TEST(Refine, IsDeterministic) {
    const RefinedSurface a = refined(torus(2, 1, 16, 8), 0, 0.2f), b = refined(torus(2, 1, 16, 8), 0, 0.2f);
    EXPECT_EQ(a.points, b.points);
    EXPECT_EQ(a.triangles, b.triangles);
}
