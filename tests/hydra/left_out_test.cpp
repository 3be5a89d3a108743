// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/leftOut.h"

#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/sdf/layer.h"

#include <gtest/gtest.h>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

UsdStageRefPtr stage() {
    const SdfLayerRefPtr layer = SdfLayer::CreateAnonymous(".usda");
    EXPECT_TRUE(layer->ImportFromString(R"(#usda 1.0
def Xform "Group"
{
    double3 xformOp:translate = (10, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Volume "Cloud"
    {
        float3[] extent = [(-1, -2, -3), (1, 2, 3)]
    }
}
def BasisCurves "Hair"
{
}
def NurbsCurves "Wire"
{
}
def BasisCurves "Hidden"
{
    token visibility = "invisible"
}
def BasisCurves "Guide"
{
    uniform token purpose = "guide"
}
def Points "Dust"
{
}
def Mesh "Mesh"
{
}
)"));
    return UsdStage::Open(layer);
}

using Sentences = std::vector<std::string>;

TEST(LeftOut, OneSentencePerType) {
    const UsdStageRefPtr scene = stage();
    EXPECT_EQ(stfrecord::describeLeftOut(scene, {HdPrimTypeTokens->mesh}, {"default"}, UsdTimeCode::Default()),
              (Sentences{"the renderer draws no curves: 2 prims are left out, the first is /Hair",
                         "the renderer draws no points: 1 prim is left out, the first is /Dust",
                         "the renderer draws no volumes: 1 prim is left out, the first is /Group/Cloud; all lie in "
                         "(9, -2, -3) to (11, 2, 3)"}));
    EXPECT_EQ(stfrecord::describeLeftOut(scene,
                                         {HdPrimTypeTokens->mesh, HdPrimTypeTokens->points, HdPrimTypeTokens->volume},
                                         {"default", "guide"}, UsdTimeCode::Default()),
              (Sentences{"the renderer draws no curves: 3 prims are left out, the first is /Hair"}));
}

TEST(LeftOut, TypesWithoutASchemaAreNamed) {
    const SdfLayerRefPtr layer = SdfLayer::CreateAnonymous(".usda");
    ASSERT_TRUE(layer->ImportFromString("#usda 1.0\ndef NoSuchType \"A\"\n{\n def Mesh \"B\"\n{\n}\n}\n"
                                        "def NoSuchType \"C\"\n{\n}\ndef \"D\"\n{\n}\n"));
    EXPECT_EQ(
        stfrecord::describeLeftOut(UsdStage::Open(layer), {HdPrimTypeTokens->mesh}, {"default"},
                                   UsdTimeCode::Default()),
        Sentences{
            "this OpenUSD has no schema for NoSuchType: 2 prims are left out with what is below, the first is /A"});
}

} // namespace
