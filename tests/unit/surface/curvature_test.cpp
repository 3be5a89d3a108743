// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/curvature.h"

#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

SurfaceGraph graphOf(ControlMesh mesh) {
    sanitize(mesh);
    return surfaceGraph(refine(mesh, {}, {}));
}

} // namespace

TEST(Curvature, OfASphereIsOneOverItsRadius) {
    for (const Curvature& c : curvatures(graphOf(sphere(24, 2.5)))) {
        EXPECT_NEAR(c.k1, 0.4, 0.004);
        EXPECT_NEAR(c.k2, 0.4, 0.004);
    }
}

TEST(Curvature, OfACylinderTurnsAroundItsAxis) {
    const SurfaceGraph g = graphOf(cylinder(0.5, 2, 80, 40));
    const std::vector<Curvature> c = curvatures(g);
    for (std::size_t v = 0; v < c.size(); ++v) {
        EXPECT_NEAR(c[v].k1, 2, 0.02);
        EXPECT_NEAR(c[v].k2, 0, 0.02);
        EXPECT_LT(std::abs(c[v].direction1.z), 0.02f);
    }
}

TEST(Curvature, OfATorusIsThatOfItsCircles) {
    const double major = 3, minor = 1;
    const SurfaceGraph g = graphOf(torus(major, minor, 160, 80));
    const std::vector<Curvature> c = curvatures(g);
    for (std::size_t v = 0; v < c.size(); ++v) {
        const Vec3f& p = g.points[v];
        const double rho = std::sqrt(double(p.x) * double(p.x) + double(p.y) * double(p.y));
        EXPECT_NEAR(c[v].k1, 1 / minor, 0.02);
        EXPECT_NEAR(c[v].k2, (rho - major) / (minor * rho), 0.02);
    }
}
