// SPDX-License-Identifier: Apache-2.0
// Cryptomattes of prims: coverages against alpha, ids against the manifest, names of instances.
#include "stfLib/render/cryptomatte.h"
#include "test_host.h"

#include "pxr/base/vt/dictionary.h"

#include <cstdio>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

constexpr int width = 16, height = 12;

/// Coverage by object, per pixel.
std::vector<std::map<std::uint32_t, float>> coverages(TestHost& host) {
    std::vector<std::map<std::uint32_t, float>> pixels(width * height);
    for (const char* layer : {"cryptoObject00", "cryptoObject01", "cryptoObject02"}) {
        const std::vector<float> values = host.floats(layer);
        for (size_t i = 0; i < values.size(); i += 2) {
            std::uint32_t id = 0;
            std::memcpy(&id, &values[i], sizeof(id));
            if (id != 0) {
                EXPECT_EQ(pixels[i / 4].count(id), 0u) << "once a pixel";
                pixels[i / 4][id] = values[i + 1];
            } else {
                EXPECT_EQ(values[i + 1], 0);
            }
        }
    }
    return pixels;
}

std::map<std::string, std::uint32_t> manifest(TestHost& host) {
    std::map<std::string, std::uint32_t> ids;
    const std::string text = VtDictionaryGet<std::string>(host.delegate->GetRenderStats(), "stf:cryptoObject");
    const nlohmann::json entries = nlohmann::json::parse(text);
    for (const auto& [name, id] : entries.items()) {
        ids[name] = static_cast<std::uint32_t>(std::stoul(id.get<std::string>(), nullptr, 16));
    }
    return ids;
}

const std::vector<std::string> aovs = {"color", "alpha", "cryptoObject00", "cryptoObject01", "cryptoObject02"};

/// Of the whole image.
float total(const std::vector<std::map<std::uint32_t, float>>& pixels, std::uint32_t id) {
    float sum = 0;
    for (const auto& pixel : pixels) {
        const auto it = pixel.find(id);
        sum += it == pixel.end() ? 0.0f : it->second;
    }
    return sum;
}

TEST(Cryptomatte, CoveragesSumToAlphaAndIdsAreInTheManifest) {
    TestHost host(testScene("color3f[] primvars:displayColor = [(0.5, 0.5, 0.5)]",
                            "def Mesh \"Ball\" {\n int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n"
                            "point3f[] points = [(-1.3, -0.7, 0.2), (0.6, -0.5, 0.2), (-0.4, 0.8, 0.2)]\n"
                            "uniform token subdivisionScheme = \"none\"\n }"),
                  aovs, width, height);
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(32));
    ASSERT_TRUE(host.renderToEnd());
    const auto pixels = coverages(host);
    const std::vector<float> alpha = host.floats("alpha");
    int partly = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
        float sum = 0;
        for (const auto& [id, share] : pixels[i]) {
            sum += share;
        }
        EXPECT_NEAR(sum, alpha[i], 1e-5f);
        partly += pixels[i].size() > 1;
    }
    EXPECT_GT(partly, 0) << "pixels that both cover";
    const auto ids = manifest(host);
    ASSERT_EQ(ids.size(), 2u);
    EXPECT_EQ(ids.at("/Square"), stf::cryptomatteId("/Square"));
    EXPECT_GT(total(pixels, ids.at("/Square")), 1);
    EXPECT_GT(total(pixels, ids.at("/Ball")), 1);
    const float known = total(pixels, ids.at("/Square")) + total(pixels, ids.at("/Ball"));
    float covered = 0;
    for (const float a : alpha) {
        covered += a;
    }
    EXPECT_NEAR(known, covered, 1e-3f) << "no other id";
}

TEST(Cryptomatte, AClearSurfaceSharesThePixelWithWhatIsBehind) {
    TestHost host(testScene("uniform token subdivisionScheme = \"none\"\n rel material:binding = </Look>", R"(
def Material "Look" {
    token outputs:surface.connect = </Look/S.outputs:surface>
    def Shader "S" {
        uniform token info:id = "UsdPreviewSurface"
        float inputs:opacity = 0.25
        token inputs:opacityMode = "presence"
        float inputs:ior = 1
        token outputs:surface
    }
}
def Mesh "Wall" {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-9, -9, -1), (9, -9, -1), (9, 9, -1), (-9, 9, -1)]
    uniform token subdivisionScheme = "none"
})"),
                  aovs, width, height);
    host.delegate->SetRenderSetting(TfToken("stf:samples"), VtValue(1024));
    ASSERT_TRUE(host.renderToEnd());
    const auto pixel = coverages(host)[6 * width + 9];
    ASSERT_EQ(pixel.size(), 2u);
    EXPECT_NEAR(pixel.at(stf::cryptomatteId("/Square")), 0.25f, 4 * 0.0135f) << "four deviations";
    EXPECT_NEAR(pixel.at(stf::cryptomatteId("/Wall")), 0.75f, 4 * 0.0135f);
}

TEST(Cryptomatte, InstancesHaveNamesOfTheirOwn) {
    TestHost host(testScene({}, R"(
def "Kind" {
    def Mesh "Tile" {
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-1, -1, 0), (-0.1, -1, 0), (-0.1, -0.1, 0), (-1, -0.1, 0)]
    }
}
def Xform "A" ( instanceable = true
    references = </Kind> ) {}
def Xform "B" ( instanceable = true
    references = </Kind> ) { double3 xformOp:translate = (0, 1.1, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
)"),
                  aovs, width, height);
    ASSERT_TRUE(host.renderToEnd());
    const auto ids = manifest(host);
    const auto pixels = coverages(host);
    for (const char* name : {"/A/Tile", "/B/Tile", "/Kind/Tile", "/Square"}) {
        ASSERT_EQ(ids.count(name), 1u) << name
                                       << VtDictionaryGet<std::string>(host.delegate->GetRenderStats(),
                                                                       "stf:cryptoObject");
    }
    EXPECT_GT(total(pixels, ids.at("/B/Tile")), 0.5f);
}

TEST(Cryptomatte, CostsNothingWhereItIsNotAskedFor) {
    TestHost host(testScene());
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(host.delegate->GetRenderStats().count("stf:cryptoObject"), 0u);
}

} // namespace
