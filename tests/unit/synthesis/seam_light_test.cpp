// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/seam_light.h"

#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>
#include <limits>

using namespace stf;
using namespace stf::test;

namespace {

constexpr double kDark = 0.2, kBright = 0.6, kDiffusionMm = 2, kWidthMm = 64;

/// A tile of 128 x 4 mm, half dark and half bright, in which light spreads over 2 mm.
Exemplar halves() {
    Exemplar e;
    e.width = 128;
    e.height = 4;
    e.texelMm = {1, 1};
    for (int i = 0; i < e.width * e.height; ++i) {
        e.response.push_back(Rgb(float(i % e.width < 64 ? kDark : kBright)));
    }
    e.diffusionMm = Vec3d(kDiffusionMm);
    return e;
}

/// A plane of 64 x 16 mm.
struct Plane {
    SurfaceGraph graph = surfaceGraph(refinedOf(rectangle(kWidthMm, 16, 128, 32)));
    SurfaceSteps steps = surfaceSteps(graph, std::vector<Vec3f>(graph.size(), Vec3f(1, 0, 0)), 1);
    SurfaceCoords coords;

    /// Shows the middle of the dark half left of x = 32.25, and what `right` mm further lies to the right of it.
    explicit Plane(float right) {
        const auto isRight = [&](std::size_t v) { return graph.points[v].x > 32.25f; };
        coords.delta = steps.stepMm;
        coords.broken.assign(graph.neighbour.size(), 0);
        for (std::size_t v = 0; v < graph.size(); ++v) {
            const Vec3f p = graph.points[v];
            coords.coord.push_back({16 + p.x * 0.5f + (isRight(v) ? right : 0.0f), p.y});
            for (int k = graph.first[v]; k < graph.first[v + 1]; ++k) {
                const std::size_t s = std::size_t(k);
                coords.delta[s].x *= 0.5f;
                coords.broken[s] = right != 0 && isRight(v) != isRight(std::size_t(graph.neighbour[s]));
            }
        }
    }
};

} // namespace

TEST(SeamLight, IsNothingWithoutSeams) {
    const Plane plane(0);
    EXPECT_EQ(seamLight(plane.graph, plane.steps, plane.coords, halves()), 0);
}

TEST(SeamLight, IsNothingWhereBothSidesAreAlike) {
    // 8 mm on within the dark half, and far from its ends: a seam that nobody sees.
    const Plane plane(8);
    EXPECT_LT(seamLight(plane.graph, plane.steps, plane.coords, halves()), 1e-3);
}

TEST(SeamLight, IsTheDecayOfAStepOnBothSidesOfIt) {
    // Dark beside bright: the jump is made up for by half of it on each side, fading as exp(-x / l). Its mean square
    // over the plane is (jump / 2)^2 l / width.
    const Plane plane(64);
    const double jump = kBright - kDark, mean = 0.5 * (kBright + kDark);
    EXPECT_NEAR(seamLight(plane.graph, plane.steps, plane.coords, halves()),
                0.5 * jump * std::sqrt(kDiffusionMm / kWidthMm) / mean, 0.002);
}

TEST(SeamLight, TakesMaterialsThatAbsorbNothingOrShowNothing) {
    const Plane plane(64);
    Exemplar e = halves();
    e.diffusionMm = Vec3d(std::numeric_limits<double>::infinity());
    const double far = seamLight(plane.graph, plane.steps, plane.coords, e);
    EXPECT_GT(far, 0);
    EXPECT_LT(far, 1);
    e.response.assign(e.response.size(), Rgb(0.0f));
    EXPECT_EQ(seamLight(plane.graph, plane.steps, plane.coords, e), 0);
}
