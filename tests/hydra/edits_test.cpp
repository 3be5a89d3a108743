// SPDX-License-Identifier: Apache-2.0
#include "test_host.h"

#include "pxr/usd/usdGeom/mesh.h"
#include "pxr/usd/usdGeom/xformCommonAPI.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

constexpr int endless = 1 << 20; // samples: rendering goes on while we edit

void translate(TestHost& host, const char* path, double x) {
    host.stage->GetPrimAtPath(SdfPath(path))
        .GetAttribute(TfToken("xformOp:translate"))
        .Set(GfVec3d(x, 0, path == std::string("/Camera") ? 5 : 0));
}

/// Both names, as scenes for all versions have them.
void setIntensity(TestHost& host, float intensity) {
    const UsdPrim light = host.stage->GetPrimAtPath(SdfPath("/Light"));
    light.GetAttribute(TfToken("intensity")).Set(intensity);
    light.GetAttribute(TfToken("inputs:intensity")).Set(intensity);
}

TEST(Edits, WithoutAnEditNothingRestarts) {
    TestHost host(testScene());
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_FALSE(host.restarts());
}

TEST(Edits, EachKindOfEditRestartsAndReachesTheScene) {
    TestHost host(testScene());
    ASSERT_TRUE(host.renderToEnd());
    const auto meshVersion = host.mesh("/Square").meshVersion;

    translate(host, "/Square", 0.5);
    EXPECT_TRUE(host.restarts());
    EXPECT_EQ(host.mesh("/Square").instances[0].objectToWorld.translation.x, 0.5);
    EXPECT_EQ(host.mesh("/Square").meshVersion, meshVersion) << "a moved mesh is not sent again";

    translate(host, "/Camera", 0.1);
    EXPECT_TRUE(host.restarts());

    setIntensity(host, 3);
    EXPECT_TRUE(host.restarts());
    EXPECT_FLOAT_EQ(host.delegate->GetScene().lights().at("/Light").emission.x, 3);

    const UsdGeomMesh square(host.stage->GetPrimAtPath(SdfPath("/Square")));
    square.GetVisibilityAttr().Set(UsdGeomTokens->invisible);
    EXPECT_TRUE(host.restarts());
    EXPECT_FALSE(host.mesh("/Square").visible);
    square.GetVisibilityAttr().Set(UsdGeomTokens->inherited);
    EXPECT_TRUE(host.restarts());
    EXPECT_TRUE(host.mesh("/Square").visible);

    square.GetPointsAttr().Set(VtVec3fArray{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
    EXPECT_TRUE(host.restarts());
    EXPECT_NE(host.mesh("/Square").meshVersion, meshVersion);
    EXPECT_EQ(host.mesh("/Square").mesh->points[2].x, 2);
}

TEST(Edits, ValuesSetToThemselvesRestartNothing) {
    TestHost host(testScene());
    ASSERT_TRUE(host.renderToEnd());
    translate(host, "/Square", 0);
    const UsdGeomMesh square(host.stage->GetPrimAtPath(SdfPath("/Square")));
    square.GetPointsAttr().Set(VtVec3fArray{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
    EXPECT_FALSE(host.restarts());
}

TEST(Edits, EditsWhileRenderingAreSafe) {
    TestHost host(testScene());
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(endless));
    for (int i = 0; i < 200; ++i) {
        switch (i % 4) {
        case 0:
            translate(host, "/Square", i * 1e-3);
            break;
        case 1:
            translate(host, "/Camera", i * 1e-3);
            break;
        case 2:
            setIntensity(host, 1 + float(i));
            break;
        default:
            host.setOutputs({"color", "depth"}, 8 + i % 13, 8 + i % 7);
        }
        host.execute();
        EXPECT_FALSE(host.converged());
        if (i % 10 == 0) {
            std::this_thread::sleep_for(std::chrono::milliseconds(3));
        }
        host.floats("color");
    }
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(2));
    EXPECT_TRUE(host.renderToEnd());
}

TEST(Edits, PrimsComeAndGoWhileRendering) {
    TestHost host(testScene());
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(endless));
    const VtVec3fArray points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (int i = 0; i < 40; ++i) {
        const UsdGeomMesh mesh = UsdGeomMesh::Define(host.stage, SdfPath("/More"));
        mesh.GetPointsAttr().Set(points);
        mesh.GetFaceVertexCountsAttr().Set(VtIntArray{4});
        mesh.GetFaceVertexIndicesAttr().Set(VtIntArray{0, 1, 2, 3});
        host.execute();
        EXPECT_EQ(host.delegate->GetScene().meshes().count("/More"), 1u);
        host.stage->RemovePrim(SdfPath("/More"));
        host.execute();
        EXPECT_EQ(host.delegate->GetScene().meshes().count("/More"), 0u);
    }
    host.stage->RemovePrim(SdfPath("/Light"));
    host.execute();
    EXPECT_TRUE(host.delegate->GetScene().lights().empty());
}

TEST(Edits, DestructionWhileRenderingIsSafe) {
    for (int i = 0; i < 10; ++i) {
        TestHost host(testScene());
        host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(endless));
        host.execute();
        std::this_thread::sleep_for(std::chrono::milliseconds(i));
    }
}

TEST(Edits, StopAndRestart) {
    TestHost host(testScene());
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(endless));
    host.execute();
    EXPECT_FALSE(host.converged());
    EXPECT_TRUE(host.delegate->Stop());
    EXPECT_TRUE(host.converged()) << "nobody may wait for a stopped renderer";
    translate(host, "/Square", 0.3);
    host.execute();
    EXPECT_TRUE(host.converged());
    host.delegate->Restart();
    EXPECT_FALSE(host.converged());
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(2));
    EXPECT_TRUE(host.renderToEnd());
}

TEST(Edits, PauseKeepsTheRestUndone) {
    TestHost host(testScene());
    host.delegate->Pause();
    host.execute();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(host.converged());
    host.delegate->Resume();
    EXPECT_TRUE(host.renderToEnd());
}

TEST(Aovs, UnknownOnesKeepTheirClearValueAndConverge) {
    TestHost host(testScene(), {"color", "noSuchAov"});
    ASSERT_TRUE(host.renderToEnd());
    for (const float value : host.floats("noSuchAov")) {
        EXPECT_EQ(value, 0.25f);
    }
    EXPECT_NE(host.messages().find("noSuchAov"), std::string::npos);

    TestHost only(testScene(), {"noSuchAov"});
    EXPECT_TRUE(only.renderToEnd());
}

TEST(Aovs, AllKnownOnesHaveDescriptors) {
    const HdStfRenderDelegate delegate;
    for (const char* name : {"color", "alpha", "depth", "cameraDepth", "normal", "Neye", "position", "albedo", "primId",
                             "instanceId", "elementId", "sampleCount", "variance", "stf:single", "stf:core"}) {
        EXPECT_NE(delegate.GetDefaultAovDescriptor(TfToken(name)).format, HdFormatInvalid) << name;
    }
    EXPECT_EQ(delegate.GetDefaultAovDescriptor(TfToken("color")).format, HdFormatFloat32Vec4);
    EXPECT_EQ(delegate.GetDefaultAovDescriptor(TfToken("primId")).format, HdFormatInt32);
}

TEST(Lights, BothSpellingsAreReadAndTheLaterOneWins) {
    TestHost host(testScene({}, R"(
        def DistantLight "Old" { float intensity = 2; float exposure = 1; }
        def DistantLight "New" { float inputs:intensity = 2; float inputs:exposure = 1; }
        def DistantLight "Both" { float intensity = 9; float inputs:intensity = 2; float inputs:exposure = 1; }
        def SphereLight "Sphere" { float intensity = 2; float radius = 3; float shaping:cone:angle = 40; }
        def RectLight "Rect" { float inputs:intensity = 2; float inputs:width = 4; bool inputs:shadow:enable = 0; }
        def CylinderLight "Cylinder" { float intensity = 2; float length = 5; bool normalize = 1; }
        def DiskLight "Disk" { float intensity = 2; asset shaping:ies:file = @lamp.ies@; })"));
    host.execute();
    const auto& lights = host.delegate->GetScene().lights();
#if HDSTF_LIGHT_PARAMS_ARE_ATTRIBUTES
    EXPECT_FLOAT_EQ(lights.at("/Old").emission.x, 4);
#endif
    EXPECT_FLOAT_EQ(lights.at("/New").emission.x, 4);
    EXPECT_FLOAT_EQ(lights.at("/Both").emission.x, 4);
    EXPECT_EQ(lights.at("/Sphere").type, stf::Light::Type::Sphere);
#if HDSTF_LIGHT_PARAMS_ARE_ATTRIBUTES
    EXPECT_FLOAT_EQ(lights.at("/Sphere").radius, 3);
    EXPECT_FLOAT_EQ(lights.at("/Sphere").shaping.coneAngle, 40);
    EXPECT_FLOAT_EQ(lights.at("/Cylinder").length, 5);
    EXPECT_TRUE(lights.at("/Cylinder").normalize);
    EXPECT_NE(lights.at("/Disk").shaping.iesFile.find("lamp.ies"), std::string::npos);
#endif
    EXPECT_EQ(lights.at("/Disk").shaping.coneAngle, 180); // nothing authored: no cone
    EXPECT_FLOAT_EQ(lights.at("/Rect").width, 4);
    EXPECT_FLOAT_EQ(lights.at("/Rect").height, 1);
    EXPECT_FALSE(lights.at("/Rect").shadows);
}

} // namespace
