// SPDX-License-Identifier: Apache-2.0
// Curves and points: what the scene gets, what the picture shows, edits.
#include "test_host.h"

#include "pxr/usd/usdGeom/basisCurves.h"
#include "pxr/usd/usdGeom/points.h"
#include "pxr/usd/usdGeom/primvarsAPI.h"

#include <gtest/gtest.h>
#include <limits>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

std::string curve(const std::string& more = {}) {
    return R"(
def BasisCurves "Curve" {
    uniform token type = "linear"
    int[] curveVertexCounts = [2]
    point3f[] points = [(-1, 0, 2), (1, 0, 2)]
)" + more + "\n}\n";
}

std::string points(const std::string& more = {}) {
    return R"(
def Points "Dots" {
    point3f[] points = [(-1, 0, 2), (1, 0, 2)]
    float[] widths = [0.5, 1] ( interpolation = "vertex" )
)" + more + "\n}\n";
}

stf::Box3f extentOf(const stf::ControlMesh& mesh) {
    stf::Box3f box;
    for (const stf::Vec3f& p : mesh.points) {
        box.add(p);
    }
    return box;
}

TEST(Curves, ArriveWithWidthColorAndLevel) {
    TestHost host(testScene({}, curve(R"(
        float[] widths = [0.2, 0.6] ( interpolation = "vertex" )
        color3f[] primvars:displayColor = [(1, 0, 0)])")));
    ASSERT_TRUE(host.renderToEnd());
    const stf::SceneMesh& mesh = host.mesh("/Curve");
    const stf::Box3f box = extentOf(*mesh.mesh);
    EXPECT_NEAR(box.lo.x, -1, 1e-5);
    EXPECT_NEAR(box.hi.x, 1, 1e-5);
    EXPECT_GT(box.hi.y, 0.27);
    EXPECT_LT(box.hi.y, 0.36);
    EXPECT_EQ(mesh.mesh->colors.at(0), stf::Rgb(1, 0, 0));
    EXPECT_EQ(mesh.instances.size(), 1u);
    EXPECT_EQ(host.messages(), "[]");
}

TEST(Curves, EditsReachTheScene) {
    TestHost host(testScene({}, curve("float[] widths = [0.2]")));
    ASSERT_TRUE(host.renderToEnd());
    const UsdGeomBasisCurves curves(host.stage->GetPrimAtPath(SdfPath("/Curve")));
    const auto extent = [&] { return extentOf(*host.mesh("/Curve").mesh); };

    curves.GetPointsAttr().Set(VtVec3fArray{{-3, 0, 2}, {1, 0, 2}});
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(extent().lo.x, -3, 1e-5);

    const float before = extent().hi.y;
    curves.GetWidthsAttr().Set(VtFloatArray{0.4f});
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(extent().hi.y, 2 * before, 1e-5);
    curves.GetWidthsAttr().Set(VtFloatArray{0.4f});
    EXPECT_FALSE(host.restarts()) << "the same value";

    curves.CreateDisplayColorAttr().Set(VtVec3fArray{{0, 1, 0}});
    EXPECT_TRUE(host.restarts());
    EXPECT_EQ(host.mesh("/Curve").mesh->colors.at(0), stf::Rgb(0, 1, 0));

    const size_t tube = host.mesh("/Curve").mesh->faceVertexCounts.size();
    curves.CreateNormalsAttr().Set(VtVec3fArray{{0, 0, 1}, {0, 0, 1}});
    EXPECT_TRUE(host.restarts());
    EXPECT_EQ(host.mesh("/Curve").mesh->faceVertexCounts.size(), 1u) << "a ribbon in place of a tube of " << tube;

    curves.GetPointsAttr().Set(VtVec3fArray{{-1, 0, 2}, {0, 0, 2}, {1, 1, 2}});
    curves.GetCurveVertexCountsAttr().Set(VtIntArray{3});
    curves.GetNormalsAttr().Clear();
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(extent().hi.y, 1, 0.4);

    curves.GetCurveVertexCountsAttr().Set(VtIntArray{});
    EXPECT_TRUE(host.restarts());
    EXPECT_EQ(host.delegate->GetScene().meshes().count("/Curve"), 0u);
    curves.GetCurveVertexCountsAttr().Set(VtIntArray{3});
    EXPECT_TRUE(host.restarts());
    EXPECT_EQ(host.delegate->GetScene().meshes().count("/Curve"), 1u);

    curves.MakeInvisible();
    EXPECT_TRUE(host.restarts());
    EXPECT_FALSE(host.mesh("/Curve").visible);
    host.stage->RemovePrim(curves.GetPath());
    host.execute();
    EXPECT_EQ(host.delegate->GetScene().meshes().count("/Curve"), 0u);
}

TEST(Curves, BadInputIsSaidOnceAndTheRestDrawn) {
    TestHost host(testScene({}, R"(
def BasisCurves "Curve" {
    uniform token type = "cubic"
    uniform token basis = "bezier"
    int[] curveVertexCounts = [4, 5, 400]
    point3f[] points = [(-1, 0, 2), (-1, 1, 2), (1, 1, 2), (1, 0, 2), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0)]
    float[] widths = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1] ( interpolation = "vertex" )
    asset primvars:stf:baseVolume = @none.vdb@ ( interpolation = "constant" )
})"));
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_NE(host.messages().find("/Curve: 2 curves left out (the number of vertices does not fit); widths ignored "
                                   "(wrong count)"),
              std::string::npos)
        << host.messages();
    EXPECT_NE(host.messages().find("/Curve: only meshes have shells"), std::string::npos) << host.messages();
    EXPECT_FALSE(host.mesh("/Curve").mesh->faceVertexCounts.empty());
    EXPECT_FALSE(host.mesh("/Curve").stf);
}

TEST(Points, ArriveAsSpheresAndAreEdited) {
    TestHost host(testScene({}, points()));
    ASSERT_TRUE(host.renderToEnd());
    const auto extent = [&] { return extentOf(*host.mesh("/Dots").mesh); };
    EXPECT_NEAR(extent().lo.x, -1.25, 0.02);
    EXPECT_NEAR(extent().hi.x, 1.5, 0.04);
    const UsdGeomPoints dots(host.stage->GetPrimAtPath(SdfPath("/Dots")));
    dots.GetWidthsAttr().Set(VtFloatArray{1, 2});
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(extent().hi.x, 2, 0.08);
    dots.GetPointsAttr().Set(VtVec3fArray{{-1, 0, 2}, {3, 0, 2}});
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(extent().hi.x, 4, 0.08);
    dots.GetPointsAttr().Set(VtVec3fArray{{-1, 0, 2}, {std::numeric_limits<float>::quiet_NaN(), 0, 2}});
    EXPECT_TRUE(host.restarts());
    EXPECT_NE(host.messages().find("/Dots: 1 point left out (not finite)"), std::string::npos) << host.messages();
    EXPECT_NEAR(extent().hi.x, -0.5, 0.04);
    dots.GetPointsAttr().Set(VtVec3fArray());
    EXPECT_TRUE(host.restarts());
    EXPECT_EQ(host.delegate->GetScene().meshes().count("/Dots"), 0u);
}

TEST(Points, ShowTheirMaterialInstancesAndIds) {
    TestHost host(testScene({}, R"(
def Material "Glow" {
    token outputs:surface.connect = </Glow/Surface.outputs:surface>
    def Shader "Surface" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (0, 0, 0)
        float inputs:ior = 1
        color3f inputs:emissiveColor = (0.5, 0.25, 0.75)
        token outputs:surface
    }
}
def PointInstancer "Many" {
    rel prototypes = [</Many/Dots>, </Many/Curve>]
    int[] protoIndices = [0, 1]
    point3f[] positions = [(-1, 0, 0), (1, 0, 0)]
    def Points "Dots" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {
        point3f[] points = [(0, 0, 3)]
        float[] widths = [4]
        rel material:binding = </Glow>
    }
    def BasisCurves "Curve" {
        uniform token type = "linear"
        int[] curveVertexCounts = [2]
        point3f[] points = [(0, -1, 2), (0, 1, 2)]
        float[] widths = [0.5]
    }
})"));
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(host.messages(), "[]");
    const std::vector<float> color = host.floats("color");
    size_t glowing = 0;
    for (size_t i = 0; i + 3 < color.size(); i += 4) {
        glowing += std::abs(color[i] - 0.5f) < 1e-4f && std::abs(color[i + 2] - 0.75f) < 1e-4f;
    }
    EXPECT_GT(glowing, 4u);
    size_t prims = 0;
    for (const auto& [id, mesh] : host.delegate->GetScene().meshes()) {
        prims += id.find("Many") != std::string::npos;
        EXPECT_EQ(mesh.instances.size(), 1u) << id;
    }
    EXPECT_EQ(prims, 2u);
}

} // namespace
