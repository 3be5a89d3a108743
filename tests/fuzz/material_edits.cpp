// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "pxr/usd/sdf/assetPath.h"
#include "pxr/usd/usdGeom/subset.h"
#include "pxr/usd/usdShade/material.h"
#include "pxr/usd/usdShade/materialBindingAPI.h"
#include "pxr/usd/usdShade/shader.h"

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

std::vector<UsdPrim> shellNodes(const Session& s) {
    std::vector<UsdPrim> nodes;
    for (const UsdPrim& material : s.prims<UsdShadeMaterial>()) {
        if (const UsdPrim node = material.GetChild(TfToken("Shell"))) {
            nodes.push_back(node);
        }
    }
    return nodes;
}

/// To any mesh, but those of native prototypes: UsdImaging 20.08 does not always bring the material of one that had
/// none before. Words for what was done.
std::string bindToAny(Session& s, const UsdShadeMaterial& material, Random& r) {
    const UsdPrim mesh = anyOf(s.prims<UsdGeomMesh>(), r);
    if (!mesh || isInstanced(mesh)) {
        return {};
    }
    UsdShadeMaterialBindingAPI(mesh).Bind(material);
    return " for " + mesh.GetPath().GetString();
}

std::string addMaterial(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/Looks", "Look", r);
    if (path.IsEmpty() || !s.stage->GetPrimAtPath(SdfPath("/Looks"))) {
        return {};
    }
    const UsdShadeMaterial material = UsdShadeMaterial::Define(s.stage, path);
    UsdShadeShader surface = UsdShadeShader::Define(s.stage, path.AppendChild(TfToken("Surface")));
    surface.CreateIdAttr(VtValue(TfToken("UsdPreviewSurface")));
    surface.CreateInput(TfToken("diffuseColor"), SdfValueTypeNames->Color3f).Set(r.vec(0, 1));
    surface.CreateOutput(TfToken("surface"), SdfValueTypeNames->Token);
    UsdShadeShader reader = UsdShadeShader::Define(s.stage, path.AppendChild(TfToken("Reader")));
    reader.CreateIdAttr(VtValue(TfToken("UsdPrimvarReader_float2")));
    reader.CreateInput(TfToken("varname"), SdfValueTypeNames->Token).Set(TfToken("st"));
    reader.CreateOutput(TfToken("result"), SdfValueTypeNames->Float2);
    UsdShadeShader texture = UsdShadeShader::Define(s.stage, path.AppendChild(TfToken("Texture")));
    texture.CreateIdAttr(VtValue(TfToken("UsdUVTexture")));
    texture.CreateInput(TfToken("file"), SdfValueTypeNames->Asset).Set(SdfAssetPath(s.files.image(0)));
    texture.CreateInput(TfToken("st"), SdfValueTypeNames->Float2)
        .ConnectToSource(reader.ConnectableAPI(), TfToken("result"));
    texture.CreateOutput(TfToken("rgb"), SdfValueTypeNames->Float3);
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), TfToken("surface"));
    return "add " + path.GetString() + bindToAny(s, material, r);
}

/// A material that is a shell. Its node is known to OpenUSD once the delegate is there.
std::string addShell(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/Looks", "Shell", r);
    if (path.IsEmpty() || !s.stage->GetPrimAtPath(SdfPath("/Looks")) || shellNodes(s).size() > 1) {
        return {};
    }
    const UsdShadeMaterial material = UsdShadeMaterial::Define(s.stage, path);
    UsdShadeShader shell = UsdShadeShader::Define(s.stage, path.AppendChild(TfToken("Shell")));
    shell.CreateIdAttr(VtValue(TfToken("StfShell")));
    shell.CreateInput(TfToken("baseVolume"), SdfValueTypeNames->Asset).Set(SdfAssetPath(s.files.volume(0)));
    shell.CreateOutput(TfToken("surface"), SdfValueTypeNames->Token);
    material.CreateSurfaceOutput(TfToken("stf")).ConnectToSource(shell.ConnectableAPI(), TfToken("surface"));
    return "add " + path.GetString() + bindToAny(s, material, r);
}

std::string setShell(Session& s, Random& r) {
    const UsdPrim node = anyOf(shellNodes(s), r);
    if (!node) {
        return {};
    }
    switch (r.below(3)) {
    case 0:
        return setAttribute(
            node, "inputs:baseVolume", SdfValueTypeNames->Asset,
            VtValue(SdfAssetPath(r.chance(0.2) ? "missing.vdb" : s.files.volume(r.below(s.files.volumes)))), r, false);
    case 1:
        return setAttribute(node, "inputs:seed", SdfValueTypeNames->Int, VtValue(r.below(3)), r, false);
    default:
        return setAttribute(node, "inputs:scale", SdfValueTypeNames->Float, VtValue(r.of({1.0f, 2.0f})), r, false);
    }
}

UsdShadeShader nodeOf(Session& s, Random& r, const char* name) {
    const UsdPrim material = anyOf(s.prims<UsdShadeMaterial>(), r);
    return material ? UsdShadeShader(material.GetChild(TfToken(name))) : UsdShadeShader();
}

std::string setSurface(Session& s, Random& r) {
    const UsdShadeShader surface = nodeOf(s, r, "Surface");
    if (!surface) {
        return {};
    }
    switch (r.below(4)) {
    case 0:
        return setAttribute(surface.GetPrim(), "inputs:diffuseColor", SdfValueTypeNames->Color3f, VtValue(r.vec(0, 1)),
                            r);
    case 1:
        return setAttribute(surface.GetPrim(), "inputs:emissiveColor", SdfValueTypeNames->Color3f,
                            VtValue(r.vec(0, 0.5f)), r, false);
    case 2:
        return setAttribute(surface.GetPrim(), "inputs:opacity", SdfValueTypeNames->Float,
                            VtValue(r.of({1.0f, 0.5f, 0.0f})), r, false);
    default:
        return setAttribute(surface.GetPrim(), r.of({"inputs:roughness", "inputs:metallic", "inputs:clearcoat"}),
                            SdfValueTypeNames->Float, VtValue(r.between(0, 1)), r, false);
    }
}

std::string connectTexture(Session& s, Random& r) {
    const UsdShadeShader surface = nodeOf(s, r, "Surface");
    if (!surface) {
        return {};
    }
    UsdShadeInput color = UsdShadeShader(surface).CreateInput(TfToken("diffuseColor"), SdfValueTypeNames->Color3f);
    if (color.HasConnectedSource()) {
        color.DisconnectSource();
        return "disconnect " + color.GetAttr().GetPath().GetString();
    }
    const UsdPrim texture = surface.GetPrim().GetParent().GetChild(TfToken("Texture"));
    if (!texture) {
        return {};
    }
    color.ConnectToSource(UsdShadeShader(texture).ConnectableAPI(), TfToken("rgb"));
    return "connect " + color.GetAttr().GetPath().GetString();
}

std::string setTexture(Session& s, Random& r) {
    const UsdShadeShader texture = nodeOf(s, r, "Texture");
    if (!texture) {
        return {};
    }
    switch (r.below(3)) {
    case 0:
        return setAttribute(
            texture.GetPrim(), "inputs:file", SdfValueTypeNames->Asset,
            VtValue(SdfAssetPath(r.chance(0.2) ? "missing.ppm" : s.files.image(r.below(s.files.images)))), r, false);
    case 1:
        return setAttribute(texture.GetPrim(), "inputs:wrapS", SdfValueTypeNames->Token,
                            VtValue(TfToken(r.of({"repeat", "clamp", "mirror", "black"}))), r, false);
    default:
        return setAttribute(texture.GetPrim(), "inputs:scale", SdfValueTypeNames->Float4,
                            VtValue(GfVec4f(r.between(0, 1))), r, false);
    }
}

std::string setReader(Session& s, Random& r) {
    const UsdShadeShader reader = nodeOf(s, r, "Reader");
    return reader ? setAttribute(reader.GetPrim(), "inputs:varname", SdfValueTypeNames->Token,
                                 VtValue(TfToken(r.of({"st", "uv", "other"}))), r, false)
                  : std::string();
}

std::string unknownNode(Session& s, Random& r) {
    const UsdShadeShader surface = nodeOf(s, r, "Surface");
    return surface ? setAttribute(surface.GetPrim(), "info:id", SdfValueTypeNames->Token,
                                  VtValue(TfToken(r.of({"UsdPreviewSurface", "UsdPreviewSurface", "NoSuchSurface"}))),
                                  r, false)
                   : std::string();
}

std::string bind(Session& s, Random& r) {
    const UsdPrim mesh = anyOf(s.prims<UsdGeomGprim>(), r);
    const UsdPrim material = anyOf(s.prims<UsdShadeMaterial>(), r);
    if (!mesh || !material || isInstanced(mesh)) {
        return {};
    }
    UsdShadeMaterialBindingAPI(mesh).Bind(UsdShadeMaterial(material));
    return "bind " + material.GetPath().GetString() + " to " + mesh.GetPath().GetString();
}

std::string unbind(Session& s, Random& r) {
    const UsdPrim mesh = anyOf(s.prims<UsdGeomGprim>(), r);
    if (!mesh || isInstanced(mesh) || !mesh.HasRelationship(TfToken("material:binding"))) {
        return {};
    }
    UsdShadeMaterialBindingAPI(mesh).UnbindDirectBinding();
    return "unbind the material of " + mesh.GetPath().GetString();
}

/// One that may go. UsdImaging does not tell a mesh that the material of a subset is gone: its faces show their
/// displayColor, as they should, but go on being a part of their own, which draws other lots.
UsdPrim anyOfNoSubset(Session& s, Random& r) {
    SdfPathSet bound;
    for (const UsdPrim& subset : s.prims<UsdGeomSubset>()) {
        bound.insert(UsdShadeMaterialBindingAPI(subset).GetDirectBinding().GetMaterialPath());
    }
    std::vector<UsdPrim> free;
    for (const UsdPrim& material : s.prims<UsdShadeMaterial>()) {
        if (!bound.count(material.GetPath())) {
            free.push_back(material);
        }
    }
    return anyOf(free, r);
}

} // namespace

void addMaterialEdits(EditKinds& kinds) {
    kinds.push_back({"material: add", 3, addMaterial});
    kinds.push_back({"material: remove", 1, [](Session& s, Random& r) { return removePrim(s, anyOfNoSubset(s, r)); }});
    kinds.push_back(
        {"material: rename", 1, [](Session& s, Random& r) { return renamePrim(s, anyOfNoSubset(s, r), r); }});
    kinds.push_back({"material: surface", 4, setSurface});
    kinds.push_back({"material: connect a texture", 3, connectTexture});
    kinds.push_back({"material: texture", 3, setTexture});
    kinds.push_back({"material: name of the coordinates", 2, setReader});
    kinds.push_back({"material: unknown node", 1, unknownNode});
    kinds.push_back({"material: add a shell", 3, addShell});
    kinds.push_back({"material: shell", 3, setShell});
    kinds.push_back({"material: bind", 3, bind});
    kinds.push_back({"material: unbind", 2, unbind});
}

} // namespace fuzz
