// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/control_mesh.h"

#include "stfLib/surface/refined_surface.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>
#include <limits>
#include <random>

using namespace stf;
using namespace stf::test;

TEST(Sanitize, LeavesAGoodMeshAlone) {
    ControlMesh mesh = rectangle(1, 1, 3, 2);
    const ControlMesh before = mesh;
    EXPECT_EQ(sanitize(mesh).summary(), "");
    EXPECT_EQ(mesh.faceVertexIndices, before.faceVertexIndices);
    EXPECT_EQ(mesh.uvIndices, before.uvIndices);
}

TEST(Sanitize, MergesRepeatedVerticesAndKeepsFaceVaryingDataInStep) {
    ControlMesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    addFace(mesh, {0, 0, 1, 2});
    addFace(mesh, {0, 2, 3, 0});
    mesh.uvs = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}, {6, 0}, {7, 0}};
    mesh.uvIndices = {0, 1, 2, 3, 4, 5, 6, 7};
    const MeshRepairs repairs = sanitize(mesh);
    EXPECT_EQ(repairs.mendedFaces, 2);
    EXPECT_EQ(mesh.faceVertexCounts, (std::vector<int>{3, 3}));
    EXPECT_EQ(mesh.faceVertexIndices, (std::vector<int>{0, 1, 2, 0, 2, 3}));
    EXPECT_EQ(mesh.uvIndices, (std::vector<int>{0, 2, 3, 4, 5, 6}));
    EXPECT_NE(repairs.summary().find("repeated vertices"), std::string::npos);
}

TEST(Sanitize, DropsFacesThatCannotBeUsed) {
    ControlMesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, std::nanf(""), 0}, {2e18f, 0, 0}};
    addFace(mesh, {0, 1, 2});
    addFace(mesh, {0, 1});       // a line
    addFace(mesh, {0, 1, 0, 2}); // a figure of eight
    addFace(mesh, {0, 1, 99});   // out of range
    addFace(mesh, {-1, 1, 2});
    addFace(mesh, {0, 1, 3}); // not a number
    addFace(mesh, {0, 1, 4}); // overflows
    mesh.faceVertexCounts.push_back(-5);
    mesh.faceVertexCounts.push_back(0);
    mesh.colors = std::vector<Rgb>(mesh.faceVertexCounts.size(), Rgb(0.1f));
    mesh.colors[0] = Rgb(0.7f);
    mesh.colorInterpolation = ControlMesh::Interpolation::Uniform;
    const MeshRepairs repairs = sanitize(mesh);
    EXPECT_EQ(repairs.droppedFaces, 8);
    EXPECT_EQ(repairs.nonFinitePoints, 2);
    EXPECT_EQ(mesh.faceVertexCounts, std::vector<int>{3});
    EXPECT_EQ(mesh.colors, std::vector<Rgb>{Rgb(0.7f)});
    for (const Vec3f& p : mesh.points) {
        EXPECT_TRUE(isFinite(p));
    }
}

// Meshes without a fault are passed at once; one bad face more, anywhere, changes nothing for the others.
TEST(Sanitize, OneBadFaceCostsNoOther) {
    ControlMesh good = rectangle(1, 1, 200, 180);
    good.holeIndices = {7, 20000};
    good.colors.resize(good.faceVertexCounts.size());
    good.colorInterpolation = ControlMesh::Interpolation::Uniform;
    for (std::size_t f = 0; f < good.colors.size(); ++f) {
        good.colors[f] = Rgb(float(f % 11) / 11);
    }
    ControlMesh passed = good;
    EXPECT_EQ(sanitize(passed).summary(), "");
    EXPECT_EQ(passed.faceVertexCounts, good.faceVertexCounts);
    EXPECT_EQ(passed.holeIndices, good.holeIndices);
    const int last = int(good.points.size()) - 1;
    for (const std::vector<int>& bad : {std::vector<int>{0, 1}, {0, 1, 0, 2}, {0, 1, last + 1}, {-1, 1, 2}}) {
        ControlMesh mended = good;
        mended.faceVertexCounts.push_back(int(bad.size()));
        mended.faceVertexIndices.insert(mended.faceVertexIndices.end(), bad.begin(), bad.end());
        mended.uvIndices.insert(mended.uvIndices.end(), bad.size(), 0);
        mended.colors.push_back(Rgb(0.5f));
        EXPECT_EQ(sanitize(mended).droppedFaces, 1);
        EXPECT_EQ(mended.faceVertexCounts, passed.faceVertexCounts);
        EXPECT_EQ(mended.faceVertexIndices, passed.faceVertexIndices);
        EXPECT_EQ(mended.uvIndices, passed.uvIndices);
        EXPECT_EQ(mended.colors, passed.colors);
        EXPECT_EQ(mended.holeIndices, passed.holeIndices);
    }
    // Face vertices of no face are dropped too.
    ControlMesh longer = good;
    longer.faceVertexIndices.push_back(0);
    longer.uvIndices.push_back(0);
    sanitize(longer);
    EXPECT_EQ(longer.faceVertexIndices, passed.faceVertexIndices);
    EXPECT_EQ(longer.uvIndices, passed.uvIndices);
    ControlMesh torn = good;
    torn.points[std::size_t(last)].y = std::nanf("");
    EXPECT_EQ(sanitize(torn).droppedFaces, 1);
}

TEST(Sanitize, EndsAtACountBeyondTheIndices) {
    ControlMesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    addFace(mesh, {0, 1, 2});
    mesh.faceVertexCounts.push_back(std::numeric_limits<int>::max());
    mesh.faceVertexCounts.push_back(3);
    EXPECT_EQ(sanitize(mesh).droppedFaces, 2);
}

TEST(Sanitize, ThrowsWhereNothingIsLeft) {
    ControlMesh empty;
    EXPECT_THROW(sanitize(empty), Error);
    ControlMesh holes = cube(ControlMesh::Scheme::CatmullClark);
    holes.holeIndices = {0, 1, 2, 3, 4, 5};
    EXPECT_THROW(sanitize(holes), Error);
    ControlMesh bad = cube(ControlMesh::Scheme::CatmullClark);
    bad.points.clear();
    try {
        sanitize(bad);
        FAIL();
    } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("no usable face"), std::string::npos);
    }
}

TEST(Sanitize, DropsDataOfWrongLengthAndTagsOutOfRange) {
    ControlMesh mesh = cube(ControlMesh::Scheme::CatmullClark);
    mesh.uvs = {{0, 0}};
    mesh.uvIndices = {0, 0, 0};
    mesh.normals = {{0, 0, 1}};
    mesh.colors = {Rgb(1), Rgb(1)};
    mesh.colorInterpolation = ControlMesh::Interpolation::FaceVarying;
    mesh.cornerIndices = {0, 100};
    mesh.cornerSharpnesses = {std::nanf(""), 1};
    mesh.creaseIndices = {0, 1, 3, -7};
    mesh.creaseLengths = {4};
    mesh.creaseSharpnesses = {99};
    mesh.holeIndices = {2, 77};
    mesh.interpolateBoundary = "sometimes";
    const MeshRepairs r = sanitize(mesh);
    EXPECT_TRUE(r.droppedUvs && r.droppedNormals && r.droppedColors && r.droppedTags);
    EXPECT_TRUE(mesh.uvIndices.empty() && mesh.normals.empty() && mesh.colors.empty());
    EXPECT_EQ(mesh.cornerIndices, std::vector<int>{0});
    EXPECT_EQ(mesh.cornerSharpnesses, std::vector<float>{0});
    EXPECT_EQ(mesh.creaseIndices, (std::vector<int>{0, 1, 1, 3}));
    EXPECT_EQ(mesh.creaseSharpnesses, (std::vector<float>{10, 10}));
    EXPECT_EQ(mesh.holeIndices, std::vector<int>{2});
    EXPECT_EQ(mesh.interpolateBoundary, "edgeAndCorner");
}

TEST(Sanitize, HolesFollowTheirFaces) {
    ControlMesh mesh = rectangle(1, 1, 3, 1);
    mesh.faceVertexIndices[0] = 1000;
    mesh.holeIndices = {1};
    sanitize(mesh);
    EXPECT_EQ(mesh.faceVertexCounts.size(), 2u);
    EXPECT_EQ(mesh.holeIndices, std::vector<int>{0});
}

// Whatever random numbers say, the result can be refined or an Error tells why not.
TEST(Sanitize, RandomNonsenseNeverCrashes) {
    std::mt19937 random(1);
    int refined = 0;
    for (int trial = 0; trial < 1000; ++trial) {
        ControlMesh mesh;
        const int points = int(random() % 12);
        for (int i = 0; i < points; ++i) {
            const auto coordinate = [&] {
                const int kind = int(random() % 60);
                return kind == 0   ? std::nanf("")
                       : kind == 1 ? std::numeric_limits<float>::infinity()
                       : kind == 2 ? 1e30f
                                   : float(int(random() % 7)) - 3.0f;
            };
            mesh.points.push_back({coordinate(), coordinate(), coordinate()});
        }
        const int faces = int(random() % 12);
        for (int f = 0; f < faces; ++f) {
            const int count = random() % 30 == 0 ? int(random()) : 3 + int(random() % 4);
            mesh.faceVertexCounts.push_back(count);
            for (int i = 0; i < std::min(count, 8); ++i) {
                mesh.faceVertexIndices.push_back(int(random() % 14) - 1);
            }
        }
        mesh.scheme = ControlMesh::Scheme(random() % 4);
        mesh.leftHanded = random() % 2;
        for (int i = 0; i < 4; ++i) {
            mesh.creaseIndices.push_back(int(random() % 14) - 1);
            mesh.uvs.push_back({float(random() % 3), float(random() % 3)});
        }
        mesh.creaseLengths = {2, 2};
        mesh.creaseSharpnesses = {float(random() % 12), 2};
        if (random() % 2) {
            for (std::size_t i = 0; i < mesh.faceVertexIndices.size(); ++i) {
                mesh.uvIndices.push_back(int(random() % 4));
            }
        }
        try {
            sanitize(mesh);
            RefineOptions options;
            options.level = int(random() % 3);
            options.targetEdge = random() % 2 ? 0.5f : 0.0f;
            options.maxLevel = 3;
            const RefinedSurface s = refine(mesh, options, {});
            ++refined;
            for (std::size_t i = 0; i < s.points.size(); ++i) {
                ASSERT_TRUE(isFinite(s.points[i]));
                ASSERT_NEAR(length(s.normals[i]), 1, 1e-3);
            }
        } catch (const Error&) {
        }
    }
    EXPECT_GT(refined, 50);
}
