// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/ray_scene.h"

#include "stfLib/surface/refined_surface.h"
#include "tests/unit/surface/test_meshes.h"

#include <gtest/gtest.h>
#include <limits>

using namespace stf;
using namespace stf::test;

namespace {

std::shared_ptr<const RayMesh> triangle() {
    return std::make_shared<RayMesh>(std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Vec3i>{{0, 1, 2}},
                                     std::vector<Vec3f>{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}});
}

Ray down(float x, float y, float from = 5) {
    return {{x, y, from}, 0, {0, 0, -1}, 1e30f};
}

} // namespace

TEST(RayMesh, HitCarriesBarycentricsAndTheRightHandNormal) {
    const auto mesh = triangle();
    RayHit hit;
    ASSERT_TRUE(mesh->intersect(down(0.25f, 0.5f), hit));
    EXPECT_EQ(hit.geometry, 0u);
    EXPECT_EQ(hit.triangle, 0u);
    EXPECT_NEAR(hit.t, 5, 1e-6);
    EXPECT_NEAR(hit.u, 0.25, 1e-6); // weight of the second corner
    EXPECT_NEAR(hit.v, 0.5, 1e-6);
    EXPECT_GT(hit.geometricNormal.z, 0);
    EXPECT_FALSE(mesh->intersect(down(0.8f, 0.8f), hit));
}

TEST(RayMesh, MaskChoosesSurfaceOrInnerBoundary) {
    const auto mesh = triangle();
    RayHit hit;
    ASSERT_TRUE(mesh->intersect(down(0.2f, 0.2f), hit, 2));
    EXPECT_EQ(hit.geometry, 1u);
    EXPECT_NEAR(hit.t, 6, 1e-6);
    ASSERT_TRUE(mesh->intersect(down(0.2f, 0.2f, -0.5f), hit, 3));
    EXPECT_EQ(hit.geometry, 1u);
    EXPECT_NEAR(hit.t, 0.5, 1e-6);
    // From below the inner boundary comes first.
    const Ray up{{0.2f, 0.2f, -5}, 0, {0, 0, 1}, 1e30f};
    ASSERT_TRUE(mesh->intersect(up, hit));
    EXPECT_EQ(hit.geometry, 1u);
    EXPECT_FALSE(mesh->occluded(down(0.2f, 0.2f, -0.5f), 1));
    EXPECT_TRUE(mesh->occluded(down(0.2f, 0.2f, -0.5f), 2));
    EXPECT_FALSE(mesh->intersect(up, hit, 0));
}

TEST(RayMesh, BadRaysAndMeshesDoNoHarm) {
    const auto mesh = triangle();
    RayHit hit;
    EXPECT_FALSE(mesh->intersect({{0.2f, 0.2f, 5}, 0, {0, 0, 0}, 1e30f}, hit));
    EXPECT_FALSE(mesh->intersect({{std::nanf(""), 0.2f, 5}, 0, {0, 0, -1}, 1e30f}, hit));
    EXPECT_FALSE(mesh->occluded({{0.2f, 0.2f, 5}, 0, {0, std::nanf(""), -1}, 1e30f}));
    EXPECT_THROW(RayMesh({{0, 0, 0}}, {{0, 0, 7}}), Error);
    EXPECT_THROW(RayMesh({{0, 0, 0}}, {{0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}), Error);
    const RayMesh empty({}, {});
    EXPECT_FALSE(empty.intersect(down(0, 0), hit));
    const RayMesh broken({{0, 0, 0}, {std::nanf(""), 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    EXPECT_FALSE(broken.intersect(down(0.1f, 0.1f), hit));
}

// Rays aimed at shared edges of a closed surface must not slip through. Exactly at a vertex Embree's robust mode loses
// about one ray in 400, which no camera will aim.
TEST(RayMesh, ClosedSurfacesAreWatertight) {
    const RefinedSurface s = refine(sphere(16), {}, {});
    const RayMesh mesh(s.points, s.triangles);
    const Vec3f from(0.1f, 0.2f, -0.05f);
    const auto missed = [&](const Vec3f& target) {
        RayHit hit;
        return !mesh.intersect({from, 0, target - from, 1e30f}, hit);
    };
    int edges = 0, vertices = 0;
    for (const Vec3i& t : s.triangles) {
        for (int c = 0; c < 3; ++c) {
            const Vec3f a = s.points[std::size_t(t[c])], b = s.points[std::size_t(t[(c + 1) % 3])];
            edges += missed(a * 0.75f + b * 0.25f) + missed((a + b) * 0.5f);
        }
    }
    for (const Vec3f& p : s.points) {
        vertices += missed(p);
    }
    EXPECT_EQ(edges, 0);
    EXPECT_LE(vertices, int(s.points.size()) / 100);
}

TEST(RayScene, InstancesReturnTheirIdAndObjectSpaceNormals) {
    const auto mesh = triangle();
    std::vector<RayInstance> instances(3);
    for (auto& i : instances) {
        i.mesh = mesh;
    }
    instances[0].objectToWorld.translation = {10, 0, 0};
    instances[0].id = 7;
    // Mirrored in x, stretched in y, moved.
    instances[1].objectToWorld.x = {-1, 0, 0};
    instances[1].objectToWorld.y = {0, 3, 0};
    instances[1].objectToWorld.translation = {20, 0, 2};
    instances[1].id = 9;
    instances[2].visible = false;
    const RayScene scene(instances);
    RayHit hit;
    ASSERT_TRUE(scene.intersect(down(10.25f, 0.5f), hit));
    EXPECT_EQ(hit.instance, 7u);
    EXPECT_EQ(hit.geometry, 0u);
    ASSERT_TRUE(scene.intersect(down(19.75f, 1.5f), hit));
    EXPECT_EQ(hit.instance, 9u);
    EXPECT_NEAR(hit.t, 3, 1e-5);
    EXPECT_NEAR(hit.u, 0.25, 1e-5);
    EXPECT_NEAR(hit.v, 0.5, 1e-5);
    EXPECT_GT(hit.geometricNormal.z, 0) << "object space, right-hand rule, whatever the transform";
    EXPECT_FALSE(scene.intersect(down(0.2f, 0.2f), hit)) << "invisible";
    EXPECT_TRUE(scene.occluded(down(19.75f, 1.5f)));
    EXPECT_FALSE(scene.occluded({{10.2f, 0.2f, -0.5f}, 0, {0, 0, -1}, 1e30f}))
        << "the inner boundary is not in the scene";
    EXPECT_NEAR(scene.bounds().lo.x, 10, 1e-4);
    EXPECT_NEAR(scene.bounds().hi.x, 20, 1e-4);
}

TEST(RayScene, SingularAndBrokenTransformsAreSkipped) {
    std::vector<RayInstance> instances(4);
    for (auto& i : instances) {
        i.mesh = triangle();
    }
    instances[0].objectToWorld.z = {0, 0, 0};
    instances[1].objectToWorld.translation.x = std::numeric_limits<double>::quiet_NaN();
    instances[2].objectToWorld.translation.x = 1e300;
    instances[3].mesh.reset();
    const RayScene scene(instances);
    RayHit hit;
    EXPECT_FALSE(scene.intersect(down(0.2f, 0.2f), hit));
    EXPECT_TRUE(scene.bounds().empty());
    EXPECT_TRUE(RayScene({}).bounds().empty());
}

TEST(RayScene, TinyAndFarInstancesAreFound) {
    std::vector<RayInstance> instances(2);
    instances[0].mesh = instances[1].mesh = triangle();
    instances[0].objectToWorld.x.x = instances[0].objectToWorld.y.y = instances[0].objectToWorld.z.z = 1e-6;
    instances[1].objectToWorld.translation = {1e6, 0, 0};
    instances[1].id = 1;
    const RayScene scene(instances);
    RayHit hit;
    ASSERT_TRUE(scene.intersect({{2e-7f, 2e-7f, 1e-5f}, 0, {0, 0, -1}, 1}, hit));
    EXPECT_EQ(hit.instance, 0u);
    ASSERT_TRUE(scene.intersect(down(1e6f + 0.25f, 0.25f), hit));
    EXPECT_EQ(hit.instance, 1u);
}

TEST(RayScene, RaysTracedTogetherMeetWhatTheyMeetAlone) {
    Transform moved, mirrored;
    moved.translation = {0.3, 0.1, -2};
    mirrored.x = {-2, 0.5, 0};
    const auto mesh = triangle();
    std::vector<RayInstance> instances(2);
    instances[0].mesh = instances[1].mesh = mesh;
    instances[0].objectToWorld = moved;
    instances[1].objectToWorld = mirrored;
    instances[0].id = 7;
    instances[1].id = 9;
    const RayScene scene(instances);
    for (int count : {1, 5, kMostTogether}) {
        Ray rays[kMostTogether];
        RayHit together[kMostTogether], alone;
        bool met[kMostTogether];
        for (int i = 0; i < count; ++i) {
            rays[i] = {{-1.5f + 0.17f * float(i), 0.2f, 5}, 0, {0.02f, 0.01f, -1}, 1e30f};
        }
        if (count > 2) {
            rays[2].direction = {0, 0, 0}; // none at all
        }
        const std::vector<float> times(kMostTogether, 0.5f);
        scene.intersectTogether(rays, times.data(), count, together, met);
        int hits = 0;
        for (int i = 0; i < count; ++i) {
            ASSERT_EQ(met[i], scene.intersect(rays[i], alone)) << i;
            if (met[i]) {
                ++hits;
                EXPECT_EQ(together[i].instance, alone.instance);
                EXPECT_EQ(together[i].triangle, alone.triangle);
                EXPECT_NEAR(together[i].t, alone.t, 1e-5);
                EXPECT_NEAR(together[i].u, alone.u, 1e-5);
                EXPECT_NEAR(together[i].v, alone.v, 1e-5);
                EXPECT_GT(dot(together[i].geometricNormal, alone.geometricNormal), 0);
            }
        }
        EXPECT_TRUE(count < kMostTogether || (hits > 3 && hits < count));
    }
    bool none = false;
    scene.intersectTogether(nullptr, nullptr, 0, nullptr, &none); // nothing is touched
    EXPECT_FALSE(none);
}
