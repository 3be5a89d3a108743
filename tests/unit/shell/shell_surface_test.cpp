// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_surface.h"

#include "stfLib/base/parallel.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

RefinedSurface refined(ControlMesh mesh, float targetEdge = 0) {
    sanitize(mesh);
    RefineOptions options;
    options.targetEdge = targetEdge;
    return refine(mesh, options, {});
}

int invertedTriangles(const RefinedSurface& s, const ShellBoundary& b) {
    int inverted = 0;
    for (const Vec3i& t : s.triangles) {
        const auto normal = [&](const std::vector<Vec3f>& p) {
            const Vec3d a(p[std::size_t(t.x)]);
            return cross(Vec3d(p[std::size_t(t.y)]) - a, Vec3d(p[std::size_t(t.z)]) - a);
        };
        inverted += dot(normal(s.points), normal(b.inner)) < 0;
    }
    return inverted;
}

} // namespace

TEST(OffsetInward, SphereShrinksByTheThickness) {
    Messages messages;
    const ShellBoundary b = offsetInward(refined(sphere(24)), 0.1f, messages.sink());
    EXPECT_EQ(b.clampedPoints, 0);
    EXPECT_TRUE(messages.text.empty());
    for (const Vec3f& p : b.inner) {
        EXPECT_NEAR(length(p), 0.9, 1e-6);
    }
}

TEST(OffsetInward, StopsBeforeTheCentreOfASphere) {
    Messages messages;
    const ShellBoundary b = offsetInward(refined(sphere(24)), 5.0f, messages.sink());
    EXPECT_EQ(b.clampedPoints, int(b.inner.size()));
    EXPECT_TRUE(messages.has("thinner than wanted"));
    // Fold-over at the radius, and the other side at twice it: 0.9 by both rules.
    for (float t : b.thickness) {
        EXPECT_NEAR(t, 0.9, 0.02);
    }
}

TEST(OffsetInward, ConcaveSidesDoNotLimit) {
    // The same sphere seen from within: moving "inward" leads away from the centre.
    ControlMesh mesh = sphere(16);
    mesh.leftHanded = true;
    mesh.normals.clear();
    const ShellBoundary b = offsetInward(refined(mesh), 3.0f, {});
    EXPECT_EQ(b.clampedPoints, 0);
    for (const Vec3f& p : b.inner) {
        EXPECT_NEAR(length(p), 4, 0.02);
    }
}

TEST(OffsetInward, AThinPlateKeepsAGapBetweenItsSides) {
    ControlMesh plate = cube(ControlMesh::Scheme::None);
    for (Vec3f& p : plate.points) {
        p.z *= 0.05f; // 2 x 2 x 0.1
    }
    const RefinedSurface s = refined(plate, 0.1f);
    Messages messages;
    const ShellBoundary b = offsetInward(s, 0.2f, messages.sink());
    EXPECT_GT(b.clampedPoints, int(s.points.size()) / 2);
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        EXPECT_GT(b.thickness[i], 0);
        EXPECT_LE(b.thickness[i], 0.2f);
        if (std::abs(s.points[i].x) < 0.5f && std::abs(s.points[i].y) < 0.5f) {
            EXPECT_LT(std::abs(b.inner[i].z), 0.05f);
            EXPECT_GT(b.inner[i].z * s.points[i].z, 0) << "the sides do not meet";
        }
    }
    EXPECT_EQ(invertedTriangles(s, b), 0);
    // Thin enough: nothing is clamped on the faces.
    const ShellBoundary thin = offsetInward(s, 0.01f, {});
    EXPECT_EQ(thin.clampedPoints, 0);
}

TEST(OffsetInward, OpenMeshesHaveNoOtherSide) {
    const RefinedSurface s = refined(rectangle(1, 1, 4, 4));
    const ShellBoundary b = offsetInward(s, 3.0f, {});
    EXPECT_EQ(b.clampedPoints, 0);
    EXPECT_NEAR(b.inner[0].z, -3, 1e-6);
    const ShellBoundary one = offsetInward(refined(rectangle(1, 1, 1, 1)), 0.1f, {});
    EXPECT_EQ(one.inner.size(), 4u);
}

TEST(OffsetInward, TorusIsClampedAtItsTubeAndNothingFoldsOver) {
    const RefinedSurface s = refined(torus(1, 0.3, 96, 48));
    const ShellBoundary b = offsetInward(s, 0.5f, {});
    EXPECT_EQ(b.clampedPoints, int(s.points.size()));
    for (float t : b.thickness) {
        EXPECT_NEAR(t, 0.27, 0.01);
    }
    EXPECT_EQ(invertedTriangles(s, b), 0);
}

// z = (x^2 - y^2) / 2: one principal curvature bends towards the inside, radius 1 at the centre.
TEST(OffsetInward, SaddleIsClampedWhereItBendsInward) {
    ControlMesh mesh = parametric(40, 40, false, false, [](double u, double v) {
        const double x = u - 0.5, y = v - 0.5;
        return Vec3d(x, y, (x * x - y * y) / 2);
    });
    for (const Vec3f& p : mesh.points) {
        mesh.normals.push_back(normalize(Vec3f(-p.x, p.y, 1)));
    }
    const RefinedSurface s = refined(mesh);
    EXPECT_EQ(offsetInward(s, 0.5f, {}).clampedPoints, 0);
    const ShellBoundary b = offsetInward(s, 2.0f, {});
    EXPECT_EQ(b.clampedPoints, int(s.points.size()));
    EXPECT_EQ(invertedTriangles(s, b), 0);
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        if (length(s.points[i]) < 0.05f) {
            EXPECT_NEAR(b.thickness[i], 0.9, 0.05);
        }
    }
}

TEST(OffsetInward, HardEdgesDoNotFoldOver) {
    for (ControlMesh::Scheme scheme : {ControlMesh::Scheme::None, ControlMesh::Scheme::Bilinear}) {
        const RefinedSurface s = refined(cube(scheme), 0.1f);
        const ShellBoundary b = offsetInward(s, 0.3f, {});
        EXPECT_EQ(invertedTriangles(s, b), 0);
    }
}

TEST(OffsetInward, DoesNotDependOnTheNumberOfThreads) {
    const RefinedSurface s = refined(torus(1, 0.3, 96, 48));
    setThreadCount(1);
    const ShellBoundary one = offsetInward(s, 0.5f, {});
    setThreadCount(2);
    const ShellBoundary two = offsetInward(s, 0.5f, {});
    setThreadCount(0);
    EXPECT_EQ(one.thickness, two.thickness);
    EXPECT_EQ(one.inner, two.inner);
}

TEST(OffsetInward, RefusesNonsense) {
    const RefinedSurface s = refined(sphere(4));
    EXPECT_THROW(offsetInward(s, 0, {}), Error);
    EXPECT_THROW(offsetInward(s, -1, {}), Error);
    EXPECT_THROW(offsetInward(s, std::nanf(""), {}), Error);
}

// Each cause has its share of the surface.
TEST(OffsetInward, SaysWhyTheShellIsThinner) {
    const ShellClamping whole = offsetInward(refined(sphere(24)), 0.1f, {}).clamping;
    EXPECT_EQ(whole.total(), 0);
    EXPECT_FLOAT_EQ(whole.lowest, 0.1f);

    // A tube of radius 0.4 folds over long before its far side is met by rays of 0.45 of the way.
    const ShellClamping tube = offsetInward(refined(torus(1, 0.4, 96, 48)), 0.39f, {}).clamping;
    EXPECT_NEAR(tube.curvature + tube.thinParts, 1, 1e-6);
    EXPECT_LE(tube.lowest, 0.37f);

    ControlMesh plate = cube(ControlMesh::Scheme::None);
    for (Vec3f& p : plate.points) {
        p.z *= 0.05f;
    }
    const ShellClamping thin = offsetInward(refined(plate, 0.1f), 0.2f, {}).clamping;
    EXPECT_GT(thin.thinParts, 0.8); // its faces
    EXPECT_LT(thin.lowest, 0.046f);
    EXPECT_LE(thin.total(), 1 + 1e-9);
}
