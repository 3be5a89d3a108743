// SPDX-License-Identifier: Apache-2.0
// Materials whose surface is an StfShell node: the mesh gets the shell that StfShellAPI would give it.
#include "test_host.h"

#include "pxr/base/plug/registry.h"
#include "pxr/usd/usdGeom/primvarsAPI.h"
#include "pxr/usd/usdShade/material.h"
#include "pxr/usd/usdShade/materialBindingAPI.h"

#include <gtest/gtest.h>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

/// The schema's resources, among them the node's definition, as the environment names them elsewhere.
const bool schemaIsKnown = !PlugRegistry::GetInstance().RegisterPlugins(STF_TEST_SCHEMA).empty();

std::string shell(const std::string& inputs, const std::string& output = "outputs:stf:surface",
                  const std::string& name = "Wax") {
    return "def Material \"" + name + "\" {\n token " + output + ".connect = </" + name +
           "/Shell.outputs:surface>\n def Shader \"Shell\" {\n uniform token info:id = \"StfShell\"\n" + inputs +
           "\n token outputs:surface\n}\n}\n";
}

const char* const volume = "asset inputs:baseVolume = @none.vdb@\n";
const char* const bound = "rel material:binding = </Wax>\n";

const std::optional<stf::StfBinding>& binding(TestHost& host) {
    return host.mesh("/Square").stf;
}

UsdAttribute input(TestHost& host, const char* name) {
    return host.stage->GetPrimAtPath(SdfPath("/Wax/Shell")).GetAttribute(TfToken(name));
}

TEST(ShellMaterial, GivesWhatTheApiGives) {
    ASSERT_TRUE(schemaIsKnown);
    const std::string inputs = R"(
        asset inputs:baseVolume = @none.vdb@
        float inputs:thickness = 0.25
        float inputs:scale = 2
        token inputs:mapping = "uv"
        token inputs:coreMaterial = "Marble"
        color3f inputs:coreSigmaA = (0.25, 0.5, 0.75)
        color3f inputs:coreSigmaSPrime = (1, 2, 3)
        token inputs:coreModel = "dipole"
        token inputs:transport = "classic"
        float inputs:quality = 0.5
        int inputs:seed = 7
)";
    std::string primvars = inputs;
    for (size_t at = 0; (at = primvars.find("inputs:", at)) != std::string::npos;) {
        primvars.replace(at, 7, "primvars:stf:");
    }
    TestHost byApi(testScene(primvars));
    byApi.execute();
    ASSERT_TRUE(binding(byApi));
    for (const char* output : {"outputs:stf:surface", "outputs:surface"}) {
        TestHost host(testScene(bound, shell(inputs, output)));
        host.execute();
        ASSERT_TRUE(binding(host)) << output << host.messages();
        EXPECT_TRUE(*binding(host) == *binding(byApi)) << output;
    }
}

TEST(ShellMaterial, EditsBindingsAndTheirEndsReachTheMesh) {
    TestHost host(
        testScene(bound, shell(std::string(volume) + "float inputs:scale = 2") +
                             shell(std::string(volume) + "float inputs:scale = 5", "outputs:surface", "Jade") +
                             "def Material \"Bare\" {}\n"));
    host.execute();
    ASSERT_TRUE(binding(host)) << host.messages();
    EXPECT_EQ(binding(host)->scale, 2);
    input(host, "inputs:scale").Set(3.0f);
    host.execute();
    EXPECT_EQ(binding(host)->scale, 3);

    if (!TestHost::bindingEditsArrive()) {
        GTEST_SKIP() << "this OpenUSD drops edits of bindings and of subsets of stages that come in by scene indices";
    }
    UsdShadeMaterialBindingAPI square(host.stage->GetPrimAtPath(SdfPath("/Square")));
    square.Bind(UsdShadeMaterial(host.stage->GetPrimAtPath(SdfPath("/Jade"))));
    host.execute();
    ASSERT_TRUE(binding(host));
    EXPECT_EQ(binding(host)->scale, 5);

    square.Bind(UsdShadeMaterial(host.stage->GetPrimAtPath(SdfPath("/Bare"))));
    host.execute();
    EXPECT_FALSE(binding(host));
    square.Bind(UsdShadeMaterial(host.stage->GetPrimAtPath(SdfPath("/Wax"))));
    host.execute();
    ASSERT_TRUE(binding(host));
    square.UnbindAllBindings();
    host.execute();
    EXPECT_FALSE(binding(host));
}

TEST(ShellMaterial, TheApiOnThePrimGoesBeforeIt) {
    TestHost host(testScene(std::string(bound) + "float primvars:stf:scale = 4 ( interpolation = \"constant\" )\n"
                                                 "float primvars:stf:quality = -1 ( interpolation = \"constant\" )\n",
                            shell(std::string(volume) + "float inputs:scale = 2\n int inputs:seed = 9\n"
                                                        "float inputs:quality = 0.5")));
    host.execute();
    ASSERT_TRUE(binding(host)) << host.messages();
    EXPECT_EQ(binding(host)->scale, 4);
    EXPECT_EQ(binding(host)->seed, 9) << "the material's, where the prim says nothing";
    EXPECT_EQ(binding(host)->quality, 0.5f) << "and where what it says cannot be";

    UsdGeomPrimvarsAPI primvars(host.stage->GetPrimAtPath(SdfPath("/Square")));
    primvars.CreatePrimvar(TfToken("stf:baseVolume"), SdfValueTypeNames->Asset, UsdGeomTokens->constant)
        .Set(SdfAssetPath("other.vdb"));
    host.execute();
    EXPECT_EQ(binding(host)->authoredPath, "other.vdb");
}

TEST(ShellMaterial, SaysWhatItCannotUse) {
    TestHost host(testScene(bound, shell(std::string(volume) + "float inputs:scale = -1")));
    host.execute();
    EXPECT_NE(host.messages().find("/Wax: inputs:scale is out of range"), std::string::npos) << host.messages();
    ASSERT_TRUE(binding(host));
    EXPECT_EQ(binding(host)->scale, 1);

    TestHost empty(testScene(bound, shell({})));
    empty.execute();
    EXPECT_NE(empty.messages().find("/Wax: StfShell has no inputs:baseVolume"), std::string::npos) << empty.messages();
    EXPECT_FALSE(binding(empty));
}

TEST(ShellMaterial, OfASubsetIsSaid) {
    TestHost host(testScene(R"(
    def GeomSubset "All" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0]
        rel material:binding = </Wax>
    })",
                            shell(volume)));
    host.execute();
    EXPECT_NE(host.messages().find("/Square: /Wax of a subset is a shell"), std::string::npos) << host.messages();
    EXPECT_FALSE(binding(host));
}

} // namespace
