// SPDX-License-Identifier: Apache-2.0
#include "test_host.h"

#include "pxr/base/gf/vec4f.h"
#include "pxr/usd/usdGeom/camera.h"
#include "pxr/usd/usdGeom/xformable.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

std::string cameraScene(const std::string& camera, const std::string& square = {}, const std::string& more = {}) {
    return R"(#usda 1.0
def Camera "Camera" {
    double3 xformOp:translate = (0, 0, 5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
)" + camera +
           R"(
}
def DistantLight "Light" {
    float intensity = 1
    float angle = 0
}
def Mesh "Square" {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
)" + square +
           "\n}\n" + more + "\n";
}

// Focal lengths are authored in tenths of scene units, focus distances in scene units.
TEST(CameraOptics, LensShutterAndExposureAreRead) {
    TestHost host(cameraScene(R"(    float focalLength = 50
    float fStop = 2
    float focusDistance = 7
    double shutter:open = -0.25
    double shutter:close = 0.5
    float exposure = 1.5)"));
    ASSERT_TRUE(host.renderToEnd());
    const stf::CameraOptics& optics = host.camera().GetOptics();
    EXPECT_NEAR(optics.lens.radius, 5.0 / (2 * 2), 1e-6);
    EXPECT_EQ(optics.lens.focusDistance, 7);
    EXPECT_EQ(optics.shutter, (stf::Shutter{-0.25, 0.5}));
    EXPECT_EQ(optics.exposure, 1.5);
}

TEST(CameraOptics, ByDefaultThereIsNone) {
    TestHost host(cameraScene(""));
    ASSERT_TRUE(host.renderToEnd());
    const stf::CameraOptics& optics = host.camera().GetOptics();
    EXPECT_FALSE(optics.lens.blurs());
    EXPECT_FALSE(optics.shutter.blurs());
    EXPECT_EQ(optics.exposure, 0);
    EXPECT_TRUE(host.mesh("/Square").instances.at(0).motion.empty());
}

TEST(CameraOptics, EditsRestart) {
    TestHost host(cameraScene("    float focusDistance = 5"));
    ASSERT_TRUE(host.renderToEnd());
    const UsdGeomCamera camera(host.stage->GetPrimAtPath(SdfPath("/Camera")));
    EXPECT_FALSE(host.restarts());
    camera.CreateFStopAttr().Set(0.5f);
    EXPECT_TRUE(host.restarts());
    EXPECT_TRUE(host.camera().GetOptics().lens.blurs());
    camera.GetFStopAttr().Set(0.5f);
    EXPECT_FALSE(host.restarts());
    host.delegate->SetRenderSetting(TfToken("stf:depthOfField"), VtValue(false));
    EXPECT_TRUE(host.restarts());
}

TEST(CameraOptics, ExposureDoublesColourPerStop) {
    TestHost host(cameraScene("    float exposure = 0"), {"color", "depth"});
    ASSERT_TRUE(host.renderToEnd());
    const std::vector<float> before = host.floats("color"), depth = host.floats("depth");
    host.stage->GetPrimAtPath(SdfPath("/Camera")).GetAttribute(TfToken("exposure")).Set(3.0f);
    EXPECT_TRUE(host.restarts());
    const std::vector<float> after = host.floats("color");
    const std::size_t middle = 4 * (6 * 16 + 8);
    ASSERT_GT(before[middle], 0.0f);
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_FLOAT_EQ(after[middle + c], 8 * before[middle + c]);
    }
    EXPECT_EQ(after[middle + 3], before[middle + 3]);
    EXPECT_EQ(host.floats("depth"), depth);
}

// Meshes and the camera give their places while the shutter is open; opening it later asks for them again.
TEST(Motion, TransformsAreSampledOverTheShutter) {
    if (!TestHost::motionIsSampled()) {
        GTEST_SKIP() << "this OpenUSD samples no motion of stages that come in by scene indices";
    }
    TestHost host(cameraScene(R"(    double shutter:open = -0.25
    double shutter:close = 0.25)",
                              R"(    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (20, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"])"));
    host.setTime(4);
    ASSERT_TRUE(host.renderToEnd());
    const auto samples = [&host] { return host.mesh("/Square").instances.at(0).motion; };
    ASSERT_EQ(samples().size(), 2u);
    EXPECT_NEAR(samples()[0].time, -0.25, 1e-6);
    EXPECT_NEAR(samples()[0].transform.translation.x, 7.5, 1e-6);
    EXPECT_NEAR(samples()[1].time, 0.25, 1e-6);
    EXPECT_NEAR(samples()[1].transform.translation.x, 8.5, 1e-6);
    EXPECT_NEAR(host.mesh("/Square").instances.at(0).objectToWorld.translation.x, 8, 1e-6);

    const UsdGeomCamera camera(host.stage->GetPrimAtPath(SdfPath("/Camera")));
    camera.GetShutterCloseAttr().Set(1.0);
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(samples().back().transform.translation.x, 10, 1e-6);
}

// As long as any camera's shutter is open, and not longer.
TEST(Motion, EndsWithTheLastShutter) {
    if (!TestHost::motionIsSampled()) {
        GTEST_SKIP() << "this OpenUSD samples no motion of stages that come in by scene indices";
    }
    TestHost host(cameraScene("", R"(    double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 10: (20, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"])",
                              "def Camera \"Second\" {}"));
    host.setTime(4);
    const auto close = [&host](const char* camera, double time) {
        UsdGeomCamera(host.stage->GetPrimAtPath(SdfPath(camera))).CreateShutterCloseAttr().Set(time);
    };
    const auto samples = [&host] { return host.mesh("/Square").instances.at(0).motion.size(); };
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(samples(), 0u);
    close("/Camera", 0.5);
    close("/Second", 0.5);
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(samples(), 2u);
    close("/Camera", 0);
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(samples(), 2u);
    close("/Second", 0);
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(samples(), 0u);
    close("/Camera", 0.5);
    close("/Second", 0.5);
    host.execute();
    EXPECT_EQ(samples(), 2u);
    close("/Camera", 0);
    close("/Second", 0);
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(samples(), 0u);
}

TEST(Motion, WhatStandsStillHasNone) {
    TestHost host(
        cameraScene("    double shutter:close = 1", R"(    double3 xformOp:translate.timeSamples = { 1: (1, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"])"));
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(host.mesh("/Square").instances.at(0).objectToWorld.translation.x, 1);
    EXPECT_TRUE(host.mesh("/Square").instances.at(0).motion.empty());
}

TEST(Motion, CamerasMove) {
    if (!TestHost::motionIsSampled()) {
        GTEST_SKIP() << "this OpenUSD samples no motion of stages that come in by scene indices";
    }
    TestHost host(R"(#usda 1.0
def Camera "Camera" {
    double shutter:open = 0
    double shutter:close = 0.5
    double3 xformOp:translate.timeSamples = { 0: (0, 0, 5), 10: (10, 0, 5) }
    float3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
}
)");
    host.setTime(4);
    ASSERT_TRUE(host.renderToEnd());
    const std::vector<stf::TransformSample> way = host.camera().GetOptics().viewToWorld;
    ASSERT_EQ(way.size(), 2u);
    EXPECT_NEAR(way[0].transform.translation.x, 4, 1e-6);
    EXPECT_NEAR(way[1].transform.translation.x, 4.5, 1e-6);
    EXPECT_NEAR(way[1].transform.translation.z, 5, 1e-6);
    EXPECT_NEAR(stf::length(way[1].transform.y), 1, 1e-9); // a camera's scale is none of its lens
}

TEST(Motion, InstancesOfPointInstancersMove) {
    if (!TestHost::motionIsSampled()) {
        GTEST_SKIP() << "this OpenUSD samples no motion of stages that come in by scene indices";
    }
    TestHost host(cameraScene(R"(    double shutter:open = 0
    double shutter:close = 1)",
                              "", R"(def PointInstancer "Many" {
    int[] protoIndices = [0, 0]
    rel prototypes = [</Many/Proto>]
    point3f[] positions.timeSamples = { 0: [(0, 0, 0), (1, 0, 0)], 2: [(0, 2, 0), (1, 0, 0)] }
    double3 xformOp:translate = (0, 0, -3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "Proto" {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    }
})"));
    host.setTime(1);
    ASSERT_TRUE(host.renderToEnd());
    const stf::SceneMesh* many = nullptr;
    for (const auto& [id, mesh] : host.delegate->GetScene().meshes()) {
        many = mesh.instances.size() == 2 ? &mesh : many;
    }
    ASSERT_NE(many, nullptr);
    const auto& moving = many->instances[0].motion;
    ASSERT_EQ(moving.size(), 2u);
    EXPECT_NEAR(moving[0].transform.translation.y, 1, 1e-6);
    EXPECT_NEAR(moving[1].transform.translation.y, 2, 1e-6);
    EXPECT_NEAR(moving[1].transform.translation.z, -3, 1e-6);
    EXPECT_TRUE(many->instances[1].motion.empty());
}

// The buffers hold a part of the frame: the same pixels as the whole.
TEST(DataWindow, PartsOfTheFrameAreThoseOfTheWhole) {
    TestHost host(cameraScene("", "    double3 xformOp:rotateXYZ = (20, 30, 40)\n"
                                  "    uniform token[] xformOpOrder = [\"xformOp:rotateXYZ\"]"),
                  {"color"}, 16, 12);
    ASSERT_TRUE(host.renderToEnd());
    const std::vector<float> whole = host.floats("color");
    struct Case {
        GfVec4f window;
        int x, y, width, height;
    };
    for (const Case& c : {Case{GfVec4f(0.25f, 0.5f, 0.75f, 0.75f), 4, 6, 8, 3},
                          Case{GfVec4f(-0.125f, -0.25f, 1.125f, 1.0f), -2, -3, 20, 15}}) {
        host.setOutputs({"color"}, c.width, c.height, 16, 12);
        host.delegate->SetRenderSetting(TfToken("dataWindowNDC"), VtValue(c.window));
        ASSERT_TRUE(host.renderToEnd());
        const std::vector<float> part = host.floats("color");
        int compared = 0;
        for (int y = std::max(0, c.y); y < std::min(12, c.y + c.height); ++y) {
            for (int x = std::max(0, c.x); x < std::min(16, c.x + c.width); ++x, ++compared) {
                for (int k = 0; k < 4; ++k) {
                    EXPECT_EQ(part[std::size_t(((y - c.y) * c.width + x - c.x) * 4 + k)],
                              whole[std::size_t((y * 16 + x) * 4 + k)]);
                }
            }
        }
        EXPECT_EQ(compared, std::min(16, c.width) * std::min(12, c.height));
    }
    // What is no window is not taken.
    host.delegate->SetRenderSetting(TfToken("dataWindowNDC"), VtValue(GfVec4f(0.5f, 0, 0.5f, 1)));
    EXPECT_EQ(host.delegate->GetDataWindowNDC(), GfVec4f(-0.125f, -0.25f, 1.125f, 1.0f));
}

} // namespace
