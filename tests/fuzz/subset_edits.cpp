// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "pxr/usd/usd/collectionAPI.h"
#include "pxr/usd/usdGeom/subset.h"
#include "pxr/usd/usdGeom/tokens.h"
#include "pxr/usd/usdShade/material.h"
#include "pxr/usd/usdShade/materialBindingAPI.h"

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

VtIntArray randomFaces(Random& r) {
    VtIntArray faces;
    for (int face = 0; face < 6; ++face) {
        if (r.chance(0.4)) {
            faces.push_back(face);
        }
    }
    return faces;
}

std::string addSubset(Session& s, Random& r) {
    const UsdGeomMesh mesh(anyOf(s.prims<UsdGeomMesh>(), r));
    const UsdPrim material = anyOf(s.prims<UsdShadeMaterial>(), r);
    if (!mesh || !material || !mesh.GetPrim().IsActive() || isInstanced(mesh.GetPrim())) {
        return {};
    }
    const TfToken name("Part" + std::to_string(r.below(3)));
    const UsdGeomSubset subset =
        UsdGeomSubset::CreateGeomSubset(mesh, name, UsdGeomTokens->face, randomFaces(r), TfToken("materialBind"));
    UsdShadeMaterialBindingAPI(subset.GetPrim()).Bind(UsdShadeMaterial(material));
    return "add " + subset.GetPath().GetString() + " with " + material.GetPath().GetString();
}

std::string setFaces(Session& s, Random& r) {
    const UsdPrim subset = anyOf(s.prims<UsdGeomSubset>(), r);
    return subset ? setAttribute(subset, "indices", SdfValueTypeNames->IntArray, VtValue(randomFaces(r)), r, false)
                  : std::string();
}

std::string bindSubset(Session& s, Random& r) {
    const UsdPrim subset = anyOf(s.prims<UsdGeomSubset>(), r);
    const UsdPrim material = anyOf(s.prims<UsdShadeMaterial>(), r);
    if (!subset || !material) {
        return {};
    }
    if (r.chance(0.3)) {
        UsdShadeMaterialBindingAPI(subset).UnbindAllBindings();
        return "unbind " + subset.GetPath().GetString();
    }
    UsdShadeMaterialBindingAPI(subset).Bind(UsdShadeMaterial(material));
    return "bind " + material.GetPath().GetString() + " to " + subset.GetPath().GetString();
}

/// Whom a light lights, or who throws its shadows.
std::string link(Session& s, Random& r) {
    std::vector<UsdPrim> lights;
    for (const UsdPrim& prim : s.stage->Traverse()) {
        if (TfStringEndsWith(prim.GetTypeName().GetString(), "Light")) {
            lights.push_back(prim);
        }
    }
    UsdPrim light = anyOf(lights, r);
    if (!light) {
        return {};
    }
    const TfToken name(r.of({"lightLink", "shadowLink"}));
#if PXR_VERSION >= 2102
    const UsdCollectionAPI collection = UsdCollectionAPI::Apply(light, name);
#else
    const UsdCollectionAPI collection = UsdCollectionAPI::ApplyCollection(light, name);
#endif
    SdfPathVector members;
    for (const UsdPrim& prim : s.prims<UsdGeomGprim>()) {
        if (r.chance(0.5) && !isInstanced(prim)) {
            members.push_back(prim.GetPath());
        }
    }
    const bool all = r.chance(0.3);
    collection.CreateIncludeRootAttr().Set(all);
    collection.CreateIncludesRel().SetTargets(all ? SdfPathVector() : members);
    return light.GetPath().GetString() + " " + name.GetString() +
           (all ? " of all" : " of " + std::to_string(members.size()) + " prims");
}

} // namespace

void addSubsetEdits(EditKinds& kinds) {
    kinds.push_back({"subset: add", 3, addSubset});
    kinds.push_back(
        {"subset: remove", 1, [](Session& s, Random& r) { return removePrim(s, anyOf(s.prims<UsdGeomSubset>(), r)); }});
    kinds.push_back({"subset: faces", 2, setFaces});
    kinds.push_back({"subset: material", 2, bindSubset});
    kinds.push_back({"light: links", 2, link});
}

} // namespace fuzz
