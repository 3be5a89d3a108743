// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/split_edges.h"

#include "stfLib/surface/surface_graph.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>
#include <map>

using namespace stf;
using namespace stf::test;

namespace {

RefinedSurface refined(ControlMesh mesh) {
    sanitize(mesh);
    return refine(mesh, {}, {});
}

double longestEdge(const RefinedSurface& s) {
    double longest = 0;
    for (const Vec3i& t : s.triangles) {
        for (int c = 0; c < 3; ++c) {
            longest =
                std::max(longest, double(length(s.points[std::size_t(t[c])] - s.points[std::size_t(t[(c + 1) % 3])])));
        }
    }
    return longest;
}

/// How many triangles each edge has: 2 everywhere on a closed surface, and no corner hangs in another's edge.
std::map<std::pair<int, int>, int> sides(const RefinedSurface& s) {
    std::map<std::pair<int, int>, int> count;
    for (const Vec3i& t : s.triangles) {
        for (int c = 0; c < 3; ++c) {
            ++count[std::minmax(t[c], t[(c + 1) % 3])];
        }
    }
    return count;
}

} // namespace

TEST(SplitEdges, LeavesNoEdgeLonger) {
    const RefinedSurface s = splitLongEdges(refined(sphere(6)), 0.05, 1000000, {});
    EXPECT_LE(longestEdge(s), 0.05);
    for (const auto& [edge, count] : sides(s)) {
        EXPECT_EQ(count, 2);
    }
}

TEST(SplitEdges, KeepsASphereRound) {
    const RefinedSurface s = splitLongEdges(refined(sphere(6)), 0.05, 1000000, {});
    double worst = 0;
    for (const Vec3f& p : s.points) {
        worst = std::max(worst, std::abs(double(length(p)) - 1));
    }
    // Edges of 0.26 rad: chords would sink by 9e-3 at their middles.
    EXPECT_LT(worst, 4e-4);
}

TEST(SplitEdges, KeepsAreaAndTextureOfAPlane) {
    const RefinedSurface s = splitLongEdges(refined(rectangle(3, 2, 3, 2)), 0.17, 1000000, {});
    EXPECT_NEAR(surfaceGraph(s).totalArea(), 6, 1e-5);
    ASSERT_EQ(s.uvTriangles.size(), s.triangles.size());
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const Vec3f p = s.points[std::size_t(s.triangles[t][c])];
            const Vec2f uv = s.uvs[std::size_t(s.uvTriangles[t][c])];
            EXPECT_NEAR(uv.x, p.x / 3, 1e-6);
            EXPECT_NEAR(uv.y, p.y / 2, 1e-6);
        }
    }
}

TEST(SplitEdges, FacetsStayFlat) {
    const RefinedSurface s = splitLongEdges(refined(cube(ControlMesh::Scheme::None)), 0.3, 1000000, {});
    ASSERT_EQ(s.cornerNormals.size(), 3 * s.triangles.size());
    for (const Vec3f& p : s.points) {
        EXPECT_NEAR(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}), 1, 1e-6);
    }
    for (const Vec3f& n : s.cornerNormals) {
        EXPECT_NEAR(std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)}), 1, 1e-6);
    }
}

TEST(SplitEdges, StopsAtTheLimitAndSaysSo) {
    Messages messages;
    const RefinedSurface s = splitLongEdges(refined(sphere(6)), 0.001, 5000, messages.sink());
    EXPECT_LE(s.triangles.size(), 5000u);
    EXPECT_TRUE(messages.has("more than the 5000 allowed")) << messages.text;
    EXPECT_THROW(splitLongEdges(s, 0, 10, {}), Error);
}
