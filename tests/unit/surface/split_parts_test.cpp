// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/split_parts.h"

#include "test_meshes.h"

#include <gtest/gtest.h>
#include <map>
#include <tuple>

namespace stf::test {
namespace {

/// What a triangle of a surface is like at its corners, whatever the points' numbers are.
using Corner = std::tuple<float, float, float, float, float, float>;

std::map<std::tuple<int, Corner, Corner, Corner>, int> triangles(const RefinedSurface& s) {
    std::map<std::tuple<int, Corner, Corner, Corner>, int> found;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        Corner c[3];
        for (int k = 0; k < 3; ++k) {
            const std::size_t i = std::size_t(s.triangles[t][k]);
            const Vec3f n = s.cornerNormals.empty() ? s.normals[i] : s.cornerNormals[3 * t + std::size_t(k)];
            c[k] = {s.points[i].x, s.points[i].y, s.points[i].z, n.x, n.y, n.z};
        }
        ++found[{s.triangleFace[t], c[0], c[1], c[2]}];
    }
    return found;
}

class SplitParts : public ::testing::TestWithParam<ControlMesh::Scheme> {};

// Together the parts are the whole, triangle by triangle, with its normals: no edge shows where they meet.
TEST_P(SplitParts, AreTheWholeWithItsNormals) {
    ControlMesh mesh = cube(GetParam());
    RefineOptions options;
    options.level = 2;
    sanitize(mesh);
    const RefinedSurface whole = refine(mesh, options, {});
    const std::vector<int> faceParts = {0, 2, 2, 0, 5, 0};
    const std::vector<SurfacePart> parts = splitByPart(whole, faceParts);
    ASSERT_EQ(parts.size(), 3u);
    std::map<std::tuple<int, Corner, Corner, Corner>, int> together;
    Box3f bounds;
    for (const SurfacePart& part : parts) {
        for (const int face : part.surface.triangleFace) {
            EXPECT_EQ(faceParts[std::size_t(face)], part.number);
        }
        for (const auto& [triangle, count] : triangles(part.surface)) {
            together[triangle] += count;
        }
        EXPECT_EQ(part.surface.normals.size(), part.surface.points.size());
        EXPECT_LT(part.surface.points.size(), whole.points.size());
        bounds.add(part.surface.bounds.lo);
        bounds.add(part.surface.bounds.hi);
    }
    EXPECT_EQ(together, triangles(whole));
    EXPECT_EQ(bounds.lo, whole.bounds.lo);
    EXPECT_EQ(bounds.hi, whole.bounds.hi);
}

INSTANTIATE_TEST_SUITE_P(Schemes, SplitParts,
                         ::testing::Values(ControlMesh::Scheme::None, ControlMesh::Scheme::CatmullClark));

TEST(SplitPartsOfFaces, FollowFacesThatAreDropped) {
    ControlMesh mesh = cube(ControlMesh::Scheme::None);
    mesh.faceVertexIndices[4] = 99; // the second face is none
    mesh.faceParts = {1, 2, 3, 4, 5, 6};
    sanitize(mesh);
    EXPECT_EQ(mesh.faceParts, (std::vector<int>{1, 3, 4, 5, 6}));
    mesh.faceParts = {1};
    sanitize(mesh);
    EXPECT_TRUE(mesh.faceParts.empty()) << "not one per face";
}

TEST(SplitPartsOfFaces, OnePartIsTheWhole) {
    ControlMesh mesh = cube(ControlMesh::Scheme::None);
    const RefinedSurface whole = refine(mesh, {}, {});
    const std::vector<SurfacePart> parts = splitByPart(whole, {});
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].number, 0);
    EXPECT_EQ(parts[0].surface.points.size(), whole.points.size());
}

} // namespace
} // namespace stf::test
