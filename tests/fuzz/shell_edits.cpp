// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "pxr/usd/sdf/assetPath.h"
#include "pxr/usd/usdGeom/primvarsAPI.h"
#include "pxr/usd/usdGeom/tokens.h"

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

const TfToken baseVolume("primvars:stf:baseVolume");

std::vector<UsdPrim> boundMeshes(const Session& s) {
    std::vector<UsdPrim> bound;
    for (const UsdPrim& prim : s.prims<UsdGeomMesh>()) {
        if (prim.HasAttribute(baseVolume)) {
            bound.push_back(prim);
        }
    }
    return bound;
}

std::string bind(Session& s, Random& r) {
    const std::vector<UsdPrim> bound = boundMeshes(s);
    // Shells take most of the time: two of them at most.
    UsdPrim prim = anyOf(bound.size() < 2 ? s.prims<UsdGeomMesh>() : bound, r);
    if (!prim) {
        return {};
    }
    prim.CreateAttribute(baseVolume, SdfValueTypeNames->Asset)
        .Set(SdfAssetPath(s.files.volume(r.below(s.files.volumes))));
    return "bind a volume to " + prim.GetPath().GetString();
}

std::string unbind(Session& s, Random& r) {
    UsdPrim prim = anyOf(boundMeshes(s), r);
    if (!prim) {
        return {};
    }
    if (r.chance(0.3)) {
        prim.GetAttribute(baseVolume).Set(SdfAssetPath("missing.vdb"));
        return "bind a missing volume to " + prim.GetPath().GetString();
    }
    prim.RemoveProperty(baseVolume);
    return "unbind " + prim.GetPath().GetString();
}

template<class Value>
std::function<std::string(Session&, Random&)> property(const char* name, const SdfValueTypeName& type, Value value) {
    return [name, type, value](Session& s, Random& r) {
        UsdPrim prim = anyOf(boundMeshes(s), r);
        const std::string full = std::string("primvars:stf:") + name;
        if (!prim) {
            return std::string();
        }
        if (prim.HasAttribute(TfToken(full)) && r.chance(0.25)) {
            prim.RemoveProperty(TfToken(full));
            return "remove " + prim.GetPath().GetString() + "." + full;
        }
        return setAttribute(prim, full, type, VtValue(value(r)), r, false);
    };
}

std::string setRest(Session& s, Random& r) {
    const UsdGeomMesh mesh(anyOf(boundMeshes(s), r));
    if (!mesh) {
        return {};
    }
    const TfToken name("primvars:stf:rest");
    if (mesh.GetPrim().HasAttribute(name) && r.chance(0.4)) {
        UsdPrim(mesh.GetPrim()).RemoveProperty(name);
        return "remove " + mesh.GetPath().GetString() + "." + name.GetString();
    }
    VtVec3fArray points;
    mesh.GetPointsAttr().Get(&points, UsdTimeCode::EarliestTime());
    if (r.chance(0.1) && !points.empty()) {
        points.pop_back();
    }
    const std::string said =
        setAttribute(mesh.GetPrim(), name.GetString(), SdfValueTypeNames->Point3fArray, VtValue(points), r, false);
    UsdGeomPrimvar(mesh.GetPrim().GetAttribute(name)).SetInterpolation(UsdGeomTokens->vertex);
    return said;
}

std::string setDirections(Session& s, Random& r) {
    const UsdGeomMesh mesh(anyOf(boundMeshes(s), r));
    if (!mesh) {
        return {};
    }
    const TfToken name("primvars:stf:orientation");
    if (mesh.GetPrim().HasAttribute(name) && r.chance(0.4)) {
        UsdPrim(mesh.GetPrim()).RemoveProperty(name);
        return "remove " + mesh.GetPath().GetString() + "." + name.GetString();
    }
    const TfToken interpolation = randomInterpolation(r);
    VtVec3fArray values;
    for (int i = valueCount(mesh, interpolation, r); i > 0; --i) {
        values.push_back(r.vec(-1, 1));
    }
    const std::string said =
        setAttribute(mesh.GetPrim(), name.GetString(), SdfValueTypeNames->Vector3fArray, VtValue(values), r, false);
    UsdGeomPrimvar(mesh.GetPrim().GetAttribute(name)).SetInterpolation(interpolation);
    return said + " (" + interpolation.GetString() + ")";
}

/// A property with a type that nobody can read.
std::string setWrongType(Session& s, Random& r) {
    UsdPrim prim = anyOf(boundMeshes(s), r);
    const TfToken name = r.of({TfToken("primvars:stf:thickness"), TfToken("primvars:stf:coreModel")});
    if (!prim) {
        return {};
    }
    prim.RemoveProperty(name);
    return setAttribute(prim, name.GetString(), SdfValueTypeNames->Bool, VtValue(true), r, false);
}

/// Files are looked at when a mesh that names them is prepared; nobody tells the delegate that one changed. So what
/// changed has to be told: every mesh that may name it gets another seed.
std::string changeFile(Session& s, Random& r, bool mend) {
    const int i = r.below(s.files.volumes);
    if (mend) {
        s.files.mendVolume(i);
    } else {
        s.files.breakVolume(i, r.chance(0.3));
    }
    const TfToken seed("primvars:stf:seed");
    for (const UsdPrim& prim : boundMeshes(s)) {
        int value = 0;
        if (const UsdAttribute held = prim.GetAttribute(seed)) {
            held.Get(&value);
        }
        prim.CreateAttribute(seed, SdfValueTypeNames->Int).Set(value + 1);
    }
    return std::string(mend ? "mend" : "break") + " volume " + std::to_string(i);
}

} // namespace

void addShellEdits(EditKinds& kinds) {
    const auto& types = *SdfValueTypeNames;
    kinds.push_back({"shell: bind", 6, bind});
    kinds.push_back({"shell: unbind", 2, unbind});
    kinds.push_back({"shell: thickness", 2, property("thickness", types.Float, [](Random& r) {
                         return r.of({0.0f, 0.06f, 0.12f, 0.5f, -1.0f});
                     })});
    kinds.push_back({"shell: scale", 2, property("scale", types.Float, [](Random& r) {
                         return r.of({0.5f, 1.0f, 1.5f, 0.0f});
                     })});
    kinds.push_back({"shell: mapping", 2, property("mapping", types.Token, [](Random& r) {
                         return TfToken(r.of({"auto", "uv", "synthesize", "blend", "nonsense"}));
                     })});
    kinds.push_back({"shell: coreMaterial", 2, property("coreMaterial", types.String, [](Random& r) {
                         return std::string(r.of({"marble", "wax", "nonsense", ""}));
                     })});
    // Cores of short ranges have tens of thousands of samples: pictures would take longer than edits are many.
    kinds.push_back(
        {"shell: coreSigmaA", 2, property("coreSigmaA", types.Color3f, [](Random& r) { return r.vec(0, 0.1f); })});
    kinds.push_back({"shell: coreSigmaSPrime", 2,
                     property("coreSigmaSPrime", types.Color3f, [](Random& r) { return r.vec(-0.02f, 0.4f); })});
    kinds.push_back({"shell: coreModel", 2, property("coreModel", types.Token, [](Random& r) {
                         return TfToken(r.of({"auto", "dipole", "walk", "none"}));
                     })});
    kinds.push_back({"shell: transport", 2, property("transport", types.Token, [](Random& r) {
                         return TfToken(r.of({"dE1", "classic", "nonsense"}));
                     })});
    kinds.push_back({"shell: quality", 1, property("quality", types.Float, [](Random& r) {
                         return r.of({0.3f, 0.5f, 0.0f});
                     })});
    kinds.push_back({"shell: seed", 2, property("seed", types.Int, [](Random& r) { return r.below(3); })});
    kinds.push_back({"shell: rest", 2, setRest});
    kinds.push_back({"shell: orientation", 2, setDirections});
    kinds.push_back({"shell: wrong type", 1, setWrongType});
    kinds.push_back({"shell: break the file", 1, [](Session& s, Random& r) { return changeFile(s, r, false); }});
    kinds.push_back({"shell: mend the file", 2, [](Session& s, Random& r) { return changeFile(s, r, true); }});
}

} // namespace fuzz
