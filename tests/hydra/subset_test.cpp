// SPDX-License-Identifier: Apache-2.0
// Materials of subsets of faces: what the scene gets, what the picture shows, edits.
#include "test_host.h"

#include "pxr/usd/usdGeom/subset.h"
#include "pxr/usd/usdShade/material.h"
#include "pxr/usd/usdShade/materialBindingAPI.h"

#include <cstring>
#include <gtest/gtest.h>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

std::string look(const std::string& name, const std::string& emission) {
    return "def Material \"" + name + "\" {\n token outputs:surface.connect = </" + name +
           "/Surface.outputs:surface>\n def Shader \"Surface\" {\n uniform token info:id = \"UsdPreviewSurface\"\n"
           "color3f inputs:diffuseColor = (0, 0, 0)\n float inputs:ior = 1\n color3f inputs:emissiveColor = " +
           emission + "\n token outputs:surface\n}\n}\n";
}

/// Three squares side by side, the right one a subset of its own.
std::string scene(const std::string& more = {}, const std::string& indices = "[2]") {
    return testScene({}, R"(
def Mesh "Row" (
    prepend apiSchemas = ["MaterialBindingAPI"]
) {
    int[] faceVertexCounts = [4, 4, 4]
    int[] faceVertexIndices = [0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6]
    point3f[] points = [(-3, -1, 1), (-1, -1, 1), (1, -1, 1), (3, -1, 1), (-3, 1, 1), (-1, 1, 1), (1, 1, 1), (3, 1, 1)]
    uniform token subdivisionScheme = "none"
    rel material:binding = </Dim>
    def GeomSubset "Right" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    ) {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = )" + indices +
                             R"(
        rel material:binding = </Bright>
    }
)" + more + "\n}\n") +
           look("Dim", "(0.25, 0.25, 0.25)") + look("Bright", "(0.75, 0.75, 0.75)") + look("Other", "(0.5, 0.5, 0.5)");
}

constexpr int width = 24, height = 8;

/// In the middle of the left, middle and right face (0, 1, 2).
template<class T>
T at(const std::vector<T>& pixels, int face, int channels = 1) {
    return pixels[static_cast<size_t>((height / 2 * width + 2 + 9 * face) * channels)];
}

struct Row : TestHost {
    explicit Row(const std::string& usda) : TestHost(usda, {"color", "elementId", "primId"}, width, height) {}
    std::vector<int> ids(const std::string& aov) {
        const std::vector<float> bits = floats(aov);
        std::vector<int> result(bits.size());
        std::memcpy(result.data(), bits.data(), bits.size() * sizeof(int));
        return result;
    }
    UsdPrim subset() { return stage->GetPrimAtPath(SdfPath("/Row/Right")); }
};

TEST(Subset, HasItsOwnMaterialAndTheIdsOfTheMesh) {
    Row host(scene());
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_EQ(host.messages(), "[]");
    EXPECT_EQ(host.mesh("/Row").material, "/Dim");
    EXPECT_EQ(host.mesh("/Row").partMaterials, std::vector<std::string>{"/Bright"});
    EXPECT_EQ(host.mesh("/Row").mesh->faceParts, (std::vector<int>{0, 0, 1}));
    const std::vector<float> color = host.floats("color");
    EXPECT_NEAR(at(color, 0, 4), 0.25f, 1e-5f);
    EXPECT_NEAR(at(color, 1, 4), 0.25f, 1e-5f);
    EXPECT_NEAR(at(color, 2, 4), 0.75f, 1e-5f);
    const std::vector<int> elements = host.ids("elementId"), prims = host.ids("primId");
    for (int face = 0; face < 3; ++face) {
        EXPECT_EQ(at(elements, face), face);
        EXPECT_EQ(at(prims, face), host.mesh("/Row").primId);
    }
}

TEST(Subset, EditsOfFacesAndBindingsReachThePicture) {
    if (!TestHost::bindingEditsArrive()) {
        GTEST_SKIP() << "this OpenUSD drops edits of bindings and of subsets of stages that come in by scene indices";
    }
    Row host(scene());
    ASSERT_TRUE(host.renderToEnd());
    UsdGeomSubset(host.subset()).GetIndicesAttr().Set(VtIntArray{0, 2});
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(at(host.floats("color"), 0, 4), 0.75f, 1e-5f);

    UsdShadeMaterialBindingAPI binding(host.subset());
    binding.Bind(UsdShadeMaterial(host.stage->GetPrimAtPath(SdfPath("/Other"))));
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(at(host.floats("color"), 0, 4), 0.5f, 1e-5f);
    EXPECT_NEAR(at(host.floats("color"), 1, 4), 0.25f, 1e-5f);

    binding.UnbindAllBindings();
    EXPECT_TRUE(host.restarts());
    EXPECT_NEAR(at(host.floats("color"), 2, 4), 0.25f, 1e-5f) << "the mesh's";
    EXPECT_TRUE(host.mesh("/Row").mesh->faceParts.empty());

    host.stage->RemovePrim(SdfPath("/Row/Right"));
    host.execute();
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_NEAR(at(host.floats("color"), 2, 4), 0.25f, 1e-5f);
}

TEST(Subset, NamesFacesThatAreNotThere) {
    Row host(scene({}, "[2, 3, -1]"));
    ASSERT_TRUE(host.renderToEnd());
    EXPECT_NE(host.messages().find("/Row: subset Right names 2 faces"), std::string::npos) << host.messages();
    EXPECT_NEAR(at(host.floats("color"), 2, 4), 0.75f, 1e-5f);
}

TEST(Subset, OfAShellIsLeftOutAndSaidOnce) {
    const std::string shell = "asset primvars:stf:baseVolume = @none.vdb@ ( interpolation = \"constant\" )\n";
    Row host(scene(shell));
    host.execute();
    EXPECT_NE(host.messages().find("/Row: a mesh with a shell is one whole"), std::string::npos) << host.messages();

    Row same(
        scene(shell + "def GeomSubset \"All\" { uniform token elementType = \"face\"\n int[] indices = [0, 1]\n }"));
    UsdShadeMaterialBindingAPI(same.subset()).Bind(UsdShadeMaterial(same.stage->GetPrimAtPath(SdfPath("/Dim"))));
    same.execute();
    EXPECT_EQ(same.messages().find("is one whole"), std::string::npos) << "all subsets have the mesh's own material";
}

} // namespace
