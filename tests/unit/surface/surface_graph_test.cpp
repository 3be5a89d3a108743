// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/surface_graph.h"

#include "tests/unit/surface/test_meshes.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

SurfaceGraph grid(double width, double height, int n) {
    ControlMesh mesh = rectangle(width, height, n, n);
    sanitize(mesh);
    return surfaceGraph(refine(mesh, {}, {}));
}

} // namespace

TEST(SurfaceGraph, FindsLinks) {
    const SurfaceGraph g = grid(4, 4, 4);
    std::size_t links = 0;
    for (std::size_t u = 0; u < g.size(); ++u) {
        for (std::size_t v = 0; v < g.size(); ++v) {
            const int k = linkOf(g, int(u), int(v));
            if (k >= 0) {
                EXPECT_GE(k, g.first[u]);
                EXPECT_LT(k, g.first[u + 1]);
                EXPECT_EQ(g.neighbour[std::size_t(k)], int(v));
                ++links;
            }
        }
    }
    EXPECT_EQ(links, g.neighbour.size());
}

TEST(SurfaceGraph, CotangentsGiveTheLaplacianOfAQuadratic) {
    // Rectangles of 1 x 0.6: sum of w (f_u - f_v) over the area of a vertex is the Laplacian of f, exactly for f = x^2
    // + 3 y^2 but for the diagonals, whose weight of zero is lifted to a twentieth.
    const SurfaceGraph g = grid(8, 4.8, 8);
    const std::vector<float> weight = cotangentWeights(g);
    std::size_t inner = 0;
    for (std::size_t v = 0; v < g.size(); ++v) {
        const Vec3f p = g.points[v];
        if (p.x < 0.5f || p.x > 7.5f || p.y < 0.3f || p.y > 4.5f) {
            continue;
        }
        ++inner;
        double sum = 0;
        for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
            const Vec3f d = g.points[std::size_t(g.neighbour[std::size_t(k)])] - p;
            if (std::abs(d.x) > 0.1f && std::abs(d.y) > 0.1f) {
                EXPECT_FLOAT_EQ(weight[std::size_t(k)], 0.05f);
                continue;
            }
            const double f = double(p.x * p.x + 3 * p.y * p.y), x = double(p.x + d.x), y = double(p.y + d.y);
            sum += double(weight[std::size_t(k)]) * (x * x + 3 * y * y - f);
        }
        EXPECT_NEAR(sum / 0.6, 2 + 6, 1e-3);
    }
    EXPECT_EQ(inner, 49u);
}
