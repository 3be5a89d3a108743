// SPDX-License-Identifier: Apache-2.0
// Opens a stage with one prim of each schema library and asks plugins, shader registry and Hydra for an answer.
#include <pxr/base/plug/registry.h>
#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/imaging/hd/rendererPluginRegistry.h>
#include <pxr/usd/sdf/fileFormat.h>
#include <pxr/usd/sdr/registry.h>
#include <pxr/usd/usd/stage.h>
#include <pxr/usd/usdGeom/mesh.h>
#include <pxr/usd/usdLux/distantLight.h>
#include <pxr/usd/usdShade/material.h>
#include <pxr/usd/usdVol/volume.h>
#include <pxr/usdImaging/usdImaging/adapterRegistry.h>
#include <pxr/usdImaging/usdImaging/delegate.h>

#include <cstdio>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {
int failures = 0;

void expect(bool good, const char* what)
{
    if (!good) {
        std::fprintf(stderr, "failed: %s\n", what);
        ++failures;
    }
}
}

int main()
{
    const char* text = "#usda 1.0\n"
                       "def Mesh \"mesh\" {\n"
                       "    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n"
                       "    int[] faceVertexCounts = [3]\n"
                       "    int[] faceVertexIndices = [0, 1, 2]\n"
                       "    color3f[] primvars:displayColor = [(1, 0.5, 0.25)]\n"
                       "}\n"
                       "def DistantLight \"light\" {\n"
                       "    float intensity = 2\n"
                       "}\n"
                       "def Material \"material\" {\n}\n"
                       "def Volume \"volume\" {\n}\n";
    SdfLayerRefPtr layer = SdfLayer::CreateAnonymous(".usda");
    expect(layer && layer->ImportFromString(text), "read a layer");
    UsdStageRefPtr stage = UsdStage::Open(layer);
    expect(static_cast<bool>(stage), "open a stage");
    if (failures)
        return 1;

    const UsdGeomMesh mesh(stage->GetPrimAtPath(SdfPath("/mesh")));
    VtVec3fArray points;
    expect(mesh && mesh.GetPointsAttr().Get(&points) && points.size() == 3, "read a mesh");
    expect(!UsdGeomMesh::GetSchemaAttributeNames().empty(), "schema attribute names");
    expect(UsdLuxDistantLight(stage->GetPrimAtPath(SdfPath("/light"))).GetAngleAttr().HasFallbackValue(), "a light's schema");
    expect(static_cast<bool>(UsdShadeMaterial(stage->GetPrimAtPath(SdfPath("/material")))), "a material");
    expect(static_cast<bool>(UsdVolVolume(stage->GetPrimAtPath(SdfPath("/volume")))), "a volume");

    UsdStageRefPtr crate = UsdStage::CreateInMemory("check.usdc");
    expect(crate && crate->GetRootLayer()->GetFileFormat()->GetFormatId() == TfToken("usdc"), "the binary format");

    for (const char* plugin : { "usdImaging", "usdVolImaging", "usdShaders", "sdrGlslfx" })
        expect(static_cast<bool>(PlugRegistry::GetInstance().GetPluginWithName(plugin)), plugin);
    expect(UsdImagingAdapterRegistry::GetInstance().HasAdapter(TfToken("Mesh")), "an adapter for meshes");
    expect(UsdImagingAdapterRegistry::GetInstance().HasAdapter(TfToken("Volume")), "an adapter for volumes");
    expect(SdrRegistry::GetInstance().GetShaderNodeByIdentifier(TfToken("UsdPreviewSurface")) != nullptr,
        "the node UsdPreviewSurface");
    HfPluginDescVector renderers;
    HdRendererPluginRegistry::GetInstance().GetPluginDescs(&renderers);
    return failures == 0 ? 0 : 1;
}
