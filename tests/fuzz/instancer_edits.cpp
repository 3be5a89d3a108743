// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "pxr/base/gf/quath.h"
#include "pxr/usd/usd/inherits.h"
#include "pxr/usd/usdGeom/pointInstancer.h"
#include "pxr/usd/usdGeom/xform.h"

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

template<class Edit>
std::function<std::string(Session&, Random&)> ofInstancer(Edit edit) {
    return [edit](Session& s, Random& r) {
        const UsdGeomPointInstancer instancer(anyOf(s.prims<UsdGeomPointInstancer>(), r));
        return instancer ? edit(instancer, r) : std::string();
    };
}

size_t instanceCount(const UsdGeomPointInstancer& instancer) {
    VtIntArray indices;
    instancer.GetProtoIndicesAttr().Get(&indices, UsdTimeCode::EarliestTime());
    return indices.size();
}

VtVec3fArray positions(size_t count, Random& r) {
    VtVec3fArray result;
    for (size_t i = 0; i < count; ++i) {
        result.push_back(r.vec(-2, 2));
    }
    return result;
}

UsdGeomMesh addPrototype(const UsdGeomPointInstancer& instancer, const char* name, Random& r) {
    const UsdGeomMesh mesh =
        UsdGeomMesh::Define(instancer.GetPrim().GetStage(), instancer.GetPath().AppendChild(TfToken(name)));
    author(mesh, randomShape(r));
    return mesh;
}

/// With two prototypes, of which one may be an instancer itself.
std::string add(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/World", "Scatter", r);
    if (path.IsEmpty() || s.prims<UsdGeomPointInstancer>().size() > 3) {
        return {};
    }
    const UsdGeomPointInstancer instancer = UsdGeomPointInstancer::Define(s.stage, path);
    addPrototype(instancer, "A", r);
    const bool nested = r.chance(0.4);
    if (nested) {
        const UsdGeomPointInstancer inner = UsdGeomPointInstancer::Define(s.stage, path.AppendChild(TfToken("B")));
        addPrototype(inner, "C", r);
        inner.CreatePrototypesRel().SetTargets({inner.GetPath().AppendChild(TfToken("C"))});
        inner.CreateProtoIndicesAttr().Set(VtIntArray{0, 0});
        inner.CreatePositionsAttr().Set(positions(2, r));
    } else {
        addPrototype(instancer, "B", r);
    }
    instancer.CreatePrototypesRel().SetTargets({path.AppendChild(TfToken("A")), path.AppendChild(TfToken("B"))});
    instancer.CreateProtoIndicesAttr().Set(VtIntArray{0, 1, 1});
    instancer.CreatePositionsAttr().Set(positions(3, r));
    return "add " + path.GetString() + (nested ? ", nested" : "");
}

std::string setPositions(const UsdGeomPointInstancer& instancer, Random& r) {
    return setAttribute(instancer.GetPrim(), "positions", SdfValueTypeNames->Point3fArray,
                        VtValue(positions(instanceCount(instancer), r)), r);
}

/// Or none any more.
template<class T>
std::string setOrRemove(const UsdGeomPointInstancer& instancer, const char* name, const SdfValueTypeName& type,
                        const VtArray<T>& values, Random& r) {
    if (instancer.GetPrim().GetAttribute(TfToken(name)).HasAuthoredValue() && r.chance(0.35)) {
        UsdPrim(instancer.GetPrim()).RemoveProperty(TfToken(name));
        return "remove " + instancer.GetPath().GetString() + "." + name;
    }
    return setAttribute(instancer.GetPrim(), name, type, VtValue(values), r);
}

std::string setScales(const UsdGeomPointInstancer& instancer, Random& r) {
    VtVec3fArray scales;
    for (size_t i = 0; i < instanceCount(instancer); ++i) {
        scales.push_back(r.vec(0.25f, 1));
    }
    return setOrRemove(instancer, "scales", SdfValueTypeNames->Float3Array, scales, r);
}

std::string setOrientations(const UsdGeomPointInstancer& instancer, Random& r) {
    VtQuathArray orientations;
    for (size_t i = 0; i < instanceCount(instancer); ++i) {
        GfQuath q(GfHalf(r.of({0.25f, 1.0f})), GfVec3h(r.vec(-1, 1)));
        orientations.push_back(q.GetNormalized());
    }
    return setOrRemove(instancer, "orientations", SdfValueTypeNames->QuathArray, orientations, r);
}

/// Another number of instances, or others of the prototypes.
std::string setIndices(const UsdGeomPointInstancer& instancer, Random& r) {
    const size_t count = size_t(r.below(4)) + (r.chance(0.9) ? 1 : 0);
    SdfPathVector prototypes;
    instancer.GetPrototypesRel().GetTargets(&prototypes);
    VtIntArray indices;
    for (size_t i = 0; i < count; ++i) {
        indices.push_back(r.below(std::max(1, int(prototypes.size()))));
    }
    instancer.GetPositionsAttr().Clear();
    instancer.GetPositionsAttr().Set(positions(count, r));
    for (const char* name : {"scales", "orientations", "ids"}) {
        UsdPrim(instancer.GetPrim()).RemoveProperty(TfToken(name));
    }
    return setAttribute(instancer.GetPrim(), "protoIndices", SdfValueTypeNames->IntArray, VtValue(indices), r, false);
}

std::string setInvisible(const UsdGeomPointInstancer& instancer, Random& r) {
    VtInt64Array ids;
    for (size_t i = 0; i < instanceCount(instancer); ++i) {
        if (r.chance(0.4)) {
            ids.push_back(int64_t(i));
        }
    }
    return setAttribute(instancer.GetPrim(), "invisibleIds", SdfValueTypeNames->Int64Array, VtValue(ids), r);
}

std::string setIds(const UsdGeomPointInstancer& instancer, Random& r) {
    VtInt64Array ids;
    for (size_t i = 0; i < instanceCount(instancer); ++i) {
        ids.push_back(int64_t(instanceCount(instancer) - 1 - i));
    }
    return setOrRemove(instancer, "ids", SdfValueTypeNames->Int64Array, ids, r);
}

std::string deactivate(const UsdGeomPointInstancer& instancer, Random& r) {
    const int64_t id = r.below(3);
    if (r.chance(0.5)) {
        instancer.ActivateId(id);
        return "activate instance " + std::to_string(id) + " of " + instancer.GetPath().GetString();
    }
    instancer.DeactivateId(id);
    return "deactivate instance " + std::to_string(id) + " of " + instancer.GetPath().GetString();
}

std::string swapPrototypes(const UsdGeomPointInstancer& instancer, Random& r) {
    const UsdRelationship rel = instancer.GetPrototypesRel();
    SdfPathVector targets;
    rel.GetTargets(&targets);
    if (targets.empty()) {
        return {};
    }
    if (r.chance(0.5)) {
        std::reverse(targets.begin(), targets.end());
    } else {
        targets.resize(1);
    }
    rel.SetTargets(targets);
    return "other prototypes for " + instancer.GetPath().GetString();
}

std::string addCopy(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/World", "Copy", r);
    if (path.IsEmpty()) {
        return {};
    }
    const UsdGeomXform copy = UsdGeomXform::Define(s.stage, path);
    copy.GetPrim().GetInherits().AddInherit(SdfPath("/Library/Thing"));
    copy.GetPrim().SetInstanceable(true);
    placeAt(copy.GetPrim(), randomPlace(r), UsdTimeCode::Default());
    return "add " + path.GetString() + ", an instance of /Library/Thing";
}

UsdPrim anyCopy(Session& s, Random& r) {
    std::vector<UsdPrim> copies;
    for (const UsdPrim& prim : s.prims<UsdGeomXform>()) {
        if (prim.HasAuthoredInherits()) {
            copies.push_back(prim);
        }
    }
    return anyOf(copies, r);
}

std::string toggleInstanceable(Session& s, Random& r) {
    const UsdPrim copy = anyCopy(s, r);
    if (!copy) {
        return {};
    }
    copy.SetInstanceable(!copy.IsInstanceable());
    return copy.GetPath().GetString() + (copy.IsInstanceable() ? " becomes an instance" : " is no instance any more");
}

} // namespace

void addInstancerEdits(EditKinds& kinds) {
    kinds.push_back({"instancer: add", 4, add});
    kinds.push_back({"instancer: remove", 1,
                     [](Session& s, Random& r) { return removePrim(s, anyOf(s.prims<UsdGeomPointInstancer>(), r)); }});
    kinds.push_back({"instancer: rename", 1, [](Session& s, Random& r) {
                         return renamePrim(s, anyOf(s.prims<UsdGeomPointInstancer>(), r), r);
                     }});
    kinds.push_back({"instancer: positions", 4, ofInstancer(setPositions)});
    kinds.push_back({"instancer: scales", 3, ofInstancer(setScales)});
    kinds.push_back({"instancer: orientations", 3, ofInstancer(setOrientations)});
    kinds.push_back({"instancer: indices", 3, ofInstancer(setIndices)});
    kinds.push_back({"instancer: invisible ids", 2, ofInstancer(setInvisible)});
    kinds.push_back({"instancer: ids", 1, ofInstancer(setIds)});
    kinds.push_back({"instancer: inactive ids", 1, ofInstancer(deactivate)});
    if (TestHost::prototypeEditsArrive()) {
        kinds.push_back({"instancer: prototypes", 2, ofInstancer(swapPrototypes)});
    }
    kinds.push_back({"native instance: add", 3, addCopy});
    kinds.push_back({"native instance: remove", 1, [](Session& s, Random& r) { return removePrim(s, anyCopy(s, r)); }});
    kinds.push_back(
        {"native instance: rename", 1, [](Session& s, Random& r) { return renamePrim(s, anyCopy(s, r), r); }});
    kinds.push_back({"native instance: instanceable", 1, toggleInstanceable});
}

} // namespace fuzz
