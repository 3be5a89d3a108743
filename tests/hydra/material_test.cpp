// SPDX-License-Identifier: Apache-2.0
// Materials: what is read of a network, and that edits reach the picture.
#include "test_host.h"

#include "pxr/base/gf/vec2f.h"
#include "pxr/usd/sdf/assetPath.h"
#include "pxr/usd/usdShade/material.h"
#include "pxr/usd/usdShade/materialBindingAPI.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

const char* const binding = R"(
    texCoord2f[] primvars:map1 = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
    texCoord2f[] primvars:st = [(0, 0), (0, 0), (0, 0), (0, 0)] ( interpolation = "vertex" )
    color3f[] primvars:displayColor = [(0.1, 0.2, 0.3)]
    uniform token subdivisionScheme = "none"
    rel material:binding = </Look>
)";

std::string look(const std::string& inputs, const std::string& nodes = {},
                 const std::string& id = "UsdPreviewSurface") {
    return R"(
def Material "Look" {
    token outputs:surface.connect = </Look/Surface.outputs:surface>
    def Shader "Surface" {
        uniform token info:id = ")" +
           id + "\"\n" + inputs + "\n token outputs:surface\n}\n" + nodes + "\n}\n";
}

const stf::PreviewSurface& surface(TestHost& host) {
    return host.delegate->GetScene().materials().at("/Look");
}

UsdAttribute input(TestHost& host, const char* shader, const char* name) {
    return host.stage->GetPrimAtPath(SdfPath(std::string("/Look/") + shader)).GetAttribute(TfToken(name));
}

/// The middle of the image, green.
float middle(TestHost& host) {
    const std::vector<float> color = host.floats("color");
    return color[4 * (6 * 16 + 9) + 1];
}

TEST(Material, ConstantsArrive) {
    TestHost host(testScene(binding, look(R"(
        color3f inputs:diffuseColor = (0.7, 0.6, 0.5)
        color3f inputs:emissiveColor = (0, 1, 2)
        int inputs:useSpecularWorkflow = 1
        color3f inputs:specularColor = (0.1, 0.2, 0.3)
        float inputs:metallic = 0.25
        float inputs:roughness = 0.75
        float inputs:clearcoat = 0.5
        float inputs:clearcoatRoughness = 0.125
        float inputs:opacity = 0.875
        float inputs:opacityThreshold = 0.0625
        float inputs:ior = 1.25
    )")));
    ASSERT_TRUE(host.renderToEnd());
    const stf::PreviewSurface& s = surface(host);
    EXPECT_EQ(s.diffuseColor.value, stf::Rgb(0.7f, 0.6f, 0.5f));
    EXPECT_EQ(s.emissiveColor.value, stf::Rgb(0, 1, 2));
    EXPECT_TRUE(s.useSpecularWorkflow);
    EXPECT_EQ(s.specularColor.value, stf::Rgb(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(s.metallic.value, 0.25f);
    EXPECT_EQ(s.roughness.value, 0.75f);
    EXPECT_EQ(s.clearcoat.value, 0.5f);
    EXPECT_EQ(s.clearcoatRoughness.value, 0.125f);
    EXPECT_EQ(s.opacity.value, 0.875f);
    EXPECT_EQ(s.opacityThreshold, 0.0625f);
    EXPECT_EQ(s.ior.value, 1.25f);
    EXPECT_EQ(host.mesh("/Square").material, "/Look");
    EXPECT_EQ(host.messages(), "[]");
}

TEST(Material, EditsOfConstantsAndBindingsReachThePicture) {
    TestHost host(testScene(binding, look("color3f inputs:diffuseColor = (0.4, 0.4, 0.4)\n float inputs:ior = 1")));
    ASSERT_TRUE(host.renderToEnd());
    const float before = middle(host);
    EXPECT_GT(before, 0.1f);

    input(host, "Surface", "inputs:diffuseColor").Set(GfVec3f(0.8f));
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(middle(host), 2 * before, 1e-4f);

    input(host, "Surface", "inputs:diffuseColor").Set(GfVec3f(0.8f));
    EXPECT_FALSE(host.restarts());

    if (!TestHost::bindingEditsArrive()) {
        GTEST_SKIP() << "this OpenUSD drops edits of bindings and of subsets of stages that come in by scene indices";
    }
    UsdShadeMaterialBindingAPI(host.stage->GetPrimAtPath(SdfPath("/Square"))).UnbindAllBindings();
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(middle(host), 0.5f * before, 1e-4f) << "its displayColor, green 0.2";
}

TEST(Material, TexturesArriveWithAllThatBelongsToThem) {
    const std::string file = (std::filesystem::temp_directory_path() / "stf_material_test.ppm").string();
    std::ofstream(file) << "P6 1 1 255\n\xff\x80" << '\0';
    const std::string nodes = R"(
    def Shader "Map" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @)" +
                              file + R"(@
        token inputs:wrapS = "repeat"
        token inputs:wrapT = "mirror"
        token inputs:sourceColorSpace = "raw"
        float4 inputs:scale = (1, 0.5, 1, 1)
        float4 inputs:bias = (0, 0.25, 0, 0)
        float4 inputs:fallback = (0, 1, 0, 1)
        float2 inputs:st.connect = </Look/Turn.outputs:result>
        float3 outputs:rgb
        float outputs:g
    }
    def Shader "Turn" {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </Look/Reader.outputs:result>
        float2 inputs:scale = (2, 3)
        float inputs:rotation = 30
        float2 inputs:translation = (0.5, 0.25)
        float2 outputs:result
    }
    def Shader "Reader" {
        uniform token info:id = "UsdPrimvarReader_float2"
        token inputs:varname = "map1"
        float2 outputs:result
    })";
    TestHost host(testScene(binding, look("color3f inputs:diffuseColor.connect = </Look/Map.outputs:rgb>\n"
                                          "float inputs:ior = 1\n"
                                          "float inputs:roughness.connect = </Look/Map.outputs:g>",
                                          nodes)));
    ASSERT_TRUE(host.renderToEnd());
    ASSERT_TRUE(surface(host).diffuseColor.texture && surface(host).roughness.texture) << host.messages();
    const stf::TextureMap map = *surface(host).diffuseColor.texture;
    EXPECT_EQ(map.file, file);
    EXPECT_EQ(map.wrapS, stf::TextureMap::Wrap::Repeat);
    EXPECT_EQ(map.wrapT, stf::TextureMap::Wrap::Mirror);
    EXPECT_EQ(map.colorSpace, stf::TextureMap::ColorSpace::Raw);
    EXPECT_EQ(map.scale[1], 0.5f);
    EXPECT_EQ(map.bias[1], 0.25f);
    EXPECT_EQ(map.fallback[1], 1);
    EXPECT_EQ(map.channel, -1);
    EXPECT_EQ(map.uvScale, stf::Vec2f(2, 3));
    EXPECT_EQ(map.uvRotation, 30);
    EXPECT_EQ(map.uvTranslation, stf::Vec2f(0.5f, 0.25f));
    EXPECT_EQ(surface(host).roughness.texture->channel, 1);
    EXPECT_EQ(host.mesh("/Square").mesh->uvs.size(), 4u) << "the coordinates that the reader names, not st";
    const float before = middle(host);
    EXPECT_EQ(host.messages(), "[]");

    input(host, "Map", "inputs:file").Set(SdfAssetPath("/none.png"));
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(middle(host), before / (128.0f / 255 * 0.5f + 0.25f), 1e-4f) << "the fallback";
    EXPECT_NE(host.messages().find("/none.png"), std::string::npos);
    std::filesystem::remove(file);
}

TEST(Material, EditsOfTheNameOfCoordinatesAndOfTheBindingReachTheMesh) {
    const std::string nodes = R"(
    def Shader "Map" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @none.ppm@
        float2 inputs:st.connect = </Look/Reader.outputs:result>
        float3 outputs:rgb
    }
    def Shader "Reader" {
        uniform token info:id = "UsdPrimvarReader_float2"
        token inputs:varname = "st"
        float2 outputs:result
    })";
    TestHost host(testScene(binding, look("color3f inputs:diffuseColor.connect = </Look/Map.outputs:rgb>", nodes) +
                                         "def Material \"Bare\" {}"));
    const auto farthest = [&] { return host.mesh("/Square").mesh->uvs.back().y; };
    host.execute();
    EXPECT_EQ(farthest(), 0) << "st";
    input(host, "Reader", "inputs:varname").Set(TfToken("map1"));
    host.execute();
    EXPECT_EQ(farthest(), 1) << "map1";

    if (!TestHost::bindingEditsArrive()) {
        GTEST_SKIP() << "this OpenUSD drops edits of bindings and of subsets of stages that come in by scene indices";
    }
    UsdShadeMaterialBindingAPI square(host.stage->GetPrimAtPath(SdfPath("/Square")));
    square.Bind(UsdShadeMaterial(host.stage->GetPrimAtPath(SdfPath("/Bare"))));
    host.execute();
    EXPECT_EQ(farthest(), 0) << "st";
    square.Bind(UsdShadeMaterial(host.stage->GetPrimAtPath(SdfPath("/Look"))));
    host.execute();
    EXPECT_EQ(farthest(), 1) << "map1";
}

TEST(Material, DisplayColorThroughAReader) {
    TestHost host(testScene(binding, look("color3f inputs:diffuseColor.connect = </Look/Color.outputs:result>", R"(
    def Shader "Color" {
        uniform token info:id = "UsdPrimvarReader_float3"
        token inputs:varname = "displayColor"
        float3 outputs:result
    })")));
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_TRUE(surface(host).diffuseIsDisplayColor) << host.messages();
}

TEST(Material, UnknownNodesAreNamedOnceAndLeaveTheDisplayColor) {
    TestHost host(testScene(binding, look("", "", "SomebodysSurface")));
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_TRUE(host.delegate->GetScene().materials().empty());
    EXPECT_GT(middle(host), 0);
}

} // namespace
