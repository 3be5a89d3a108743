// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_tree.h"

#include "stfLib/base/random.h"
#include "tests/unit/acquire/meshes.h"

using namespace stf;
using namespace stf::test;

namespace {

Vec3d randomPoint(CounterRng& rng, double half) {
    return Vec3d(double(rng.uniform()) - 0.5, double(rng.uniform()) - 0.5, double(rng.uniform()) - 0.5) * (2 * half);
}

TEST(MeshTree, WindingNumberOfAClosedMeshIsOneInsideAndZeroOutside) {
    const TriangleTree tree(sphereMesh(1, {3, 0, 0}, 3));
    CounterRng rng(1, 0);
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d p = randomPoint(rng, 1.6);
        if (std::abs(length(p) - 1) < 0.02) {
            continue; // between the facets and the sphere
        }
        inside += length(p) < 1;
        EXPECT_NEAR(tree.windingNumber(p + Vec3d(3, 0, 0)), length(p) < 1 ? 1 : 0, 0.01);
    }
    EXPECT_GT(inside, 100);
}

TEST(MeshTree, WindingNumberOfACapIsItsSolidAngle) {
    // A sphere without its top, seen from the middle: the share of the solid angle that is left.
    TriangleMesh m = sphereMesh(1, {0, 0, 0}, 5), open = m;
    open.triangles.clear();
    for (std::size_t i = 0; i < m.triangles.size(); ++i) {
        if (std::max({m.corner(i, 0).z, m.corner(i, 1).z, m.corner(i, 2).z}) < 0.5) {
            open.triangles.push_back(m.triangles[i]);
        }
    }
    // The rim is one triangle wide.
    EXPECT_NEAR(TriangleTree(open).windingNumber({0, 0, 0}), 0.75, 0.02);
    EXPECT_NEAR(TriangleTree(turnedOver(open)).windingNumber({0, 0, 0}), -0.75, 0.02);
}

TEST(MeshTree, DistanceIsThatOfAllTrianglesTried) {
    // An independent computation: the nearest of dense samples of the surface.
    const TriangleMesh box = boxMesh({2, 1, 3}, {0, 0, 0});
    const TriangleTree tree(box);
    CounterRng rng(2, 0);
    for (int i = 0; i < 500; ++i) {
        const Vec3d p = randomPoint(rng, 3);
        const Vec3d q(std::abs(p.x) - 1, std::abs(p.y) - 0.5, std::abs(p.z) - 1.5);
        const Vec3d out(std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0));
        const double expected = maxComponent(q) > 0 ? length(out) : -maxComponent(q);
        EXPECT_NEAR(tree.distance(p), expected, 1e-12);
        EXPECT_EQ(tree.distance(p, 0.5 * expected), 0.5 * expected) << "bounded";
    }
}

} // namespace
