// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "pxr/base/tf/stringUtils.h"
#include "pxr/usd/sdf/namespaceEdit.h"
#include "pxr/usd/usdGeom/camera.h"
#include "pxr/usd/usdGeom/pointInstancer.h"
#include "pxr/usd/usdGeom/primvarsAPI.h"
#include "pxr/usd/usdGeom/tokens.h"
#include "pxr/usd/usdGeom/xform.h"

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

UsdGeomMesh anyMesh(const Session& s, Random& r) {
    return UsdGeomMesh(anyOf(s.prims<UsdGeomMesh>(), r));
}

/// An edit of one mesh.
template<class Edit>
std::function<std::string(Session&, Random&)> ofMesh(Edit edit) {
    return [edit](Session& s, Random& r) {
        UsdGeomMesh mesh = anyMesh(s, r);
        return mesh ? edit(mesh, r) : std::string();
    };
}

std::string addMesh(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/World", "Mesh", r);
    if (path.IsEmpty() || s.prims<UsdGeomMesh>().size() > 8) {
        return {};
    }
    const UsdGeomMesh mesh = UsdGeomMesh::Define(s.stage, path);
    const Shape shape = randomShape(r);
    author(mesh, shape);
    placeAt(mesh.GetPrim(), randomPlace(r), UsdTimeCode::Default());
    mesh.GetSubdivisionSchemeAttr().Set(r.of({UsdGeomTokens->none, UsdGeomTokens->catmullClark}));
    return "add " + path.GetString() + ", a " + shape.name;
}

std::string movePoints(const UsdGeomMesh& mesh, Random& r) {
    VtVec3fArray points;
    mesh.GetPointsAttr().Get(&points, UsdTimeCode::EarliestTime());
    for (GfVec3f& p : points) {
        p += r.vec(-0.3f, 0.3f);
    }
    return setAttribute(mesh.GetPrim(), "points", SdfValueTypeNames->Point3fArray, VtValue(points), r);
}

std::string retopologise(const UsdGeomMesh& mesh, Random& r) {
    // Samples of the old points would not fit.
    for (const UsdAttribute& a :
         {mesh.GetPointsAttr(), mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()}) {
        a.Clear();
    }
    const Shape shape = randomShape(r);
    author(mesh, shape);
    return mesh.GetPath().GetString() + " becomes a " + shape.name;
}

std::string empty(const UsdGeomMesh& mesh, Random& r) {
    mesh.GetFaceVertexCountsAttr().Set(VtIntArray());
    if (r.chance(0.5)) {
        mesh.GetFaceVertexIndicesAttr().Set(VtIntArray());
    }
    return mesh.GetPath().GetString() + " loses its faces";
}

std::string setScheme(const UsdGeomMesh& mesh, Random& r) {
    return setAttribute(
        mesh.GetPrim(), "subdivisionScheme", SdfValueTypeNames->Token,
        VtValue(r.of({UsdGeomTokens->none, UsdGeomTokens->catmullClark, UsdGeomTokens->bilinear, UsdGeomTokens->loop})),
        r, false);
}

std::string setOrientation(const UsdGeomMesh& mesh, Random& r) {
    return setAttribute(mesh.GetPrim(), "orientation", SdfValueTypeNames->Token,
                        VtValue(r.of({UsdGeomTokens->leftHanded, UsdGeomTokens->rightHanded})), r, false);
}

std::string setTags(const UsdGeomMesh& mesh, Random& r) {
    switch (r.below(4)) {
    case 0:
        mesh.GetCreaseIndicesAttr().Set(VtIntArray{0, 1});
        mesh.GetCreaseLengthsAttr().Set(VtIntArray{2});
        return setAttribute(mesh.GetPrim(), "creaseSharpnesses", SdfValueTypeNames->FloatArray,
                            VtValue(VtFloatArray{r.of({0.5f, 2.0f, 10.0f})}), r, false);
    case 1:
        mesh.GetCornerIndicesAttr().Set(VtIntArray{r.below(4)});
        return setAttribute(mesh.GetPrim(), "cornerSharpnesses", SdfValueTypeNames->FloatArray,
                            VtValue(VtFloatArray{r.of({0.5f, 10.0f})}), r, false);
    case 2:
        return setAttribute(mesh.GetPrim(), "interpolateBoundary", SdfValueTypeNames->Token,
                            VtValue(r.of({UsdGeomTokens->none, UsdGeomTokens->edgeOnly, UsdGeomTokens->edgeAndCorner})),
                            r, false);
    default:
        return setAttribute(mesh.GetPrim(), "holeIndices", SdfValueTypeNames->IntArray,
                            VtValue(r.chance(0.5) ? VtIntArray{0} : VtIntArray{}), r, false);
    }
}

/// A primvar of vectors, with any interpolation; or none any more.
std::string setVectors(const UsdGeomMesh& mesh, const std::string& name, const SdfValueTypeName& type, float low,
                       float high, Random& r) {
    UsdGeomPrimvarsAPI api(mesh.GetPrim());
    const UsdGeomPrimvar held = api.GetPrimvar(TfToken(name));
    if (held && r.chance(0.2)) {
        if (r.chance(0.5)) {
            UsdPrim(mesh.GetPrim()).RemoveProperty(held.GetName());
            return "remove " + mesh.GetPath().GetString() + "." + held.GetName().GetString();
        }
        held.GetAttr().Block();
        return "block " + held.GetAttr().GetPath().GetString();
    }
    const TfToken interpolation = randomInterpolation(r);
    VtVec3fArray values;
    for (int i = valueCount(mesh, interpolation, r); i > 0; --i) {
        values.push_back(r.vec(low, high));
    }
    UsdGeomPrimvar primvar = api.CreatePrimvar(TfToken(name), type, interpolation);
    primvar.SetInterpolation(interpolation);
    return setAttribute(mesh.GetPrim(), "primvars:" + name, type, VtValue(values), r) + " (" +
           interpolation.GetString() + ")";
}

std::string setColor(const UsdGeomMesh& mesh, Random& r) {
    return setVectors(mesh, "displayColor", SdfValueTypeNames->Color3fArray, 0, 1, r);
}

std::string setNormals(const UsdGeomMesh& mesh, Random& r) {
    if (r.chance(0.5)) {
        return setVectors(mesh, "normals", SdfValueTypeNames->Normal3fArray, -1, 1, r);
    }
    if (r.chance(0.2)) {
        UsdPrim(mesh.GetPrim()).RemoveProperty(UsdGeomTokens->normals);
        return "remove " + mesh.GetPath().GetString() + ".normals";
    }
    const TfToken interpolation = randomInterpolation(r);
    VtVec3fArray values;
    for (int i = valueCount(mesh, interpolation, r); i > 0; --i) {
        values.push_back(r.vec(-1, 1));
    }
    UsdGeomMesh(mesh).SetNormalsInterpolation(interpolation);
    return setAttribute(mesh.GetPrim(), "normals", SdfValueTypeNames->Normal3fArray, VtValue(values), r) + " (" +
           interpolation.GetString() + ")";
}

std::string setUvs(const UsdGeomMesh& mesh, Random& r) {
    UsdGeomPrimvarsAPI api(mesh.GetPrim());
    const TfToken name = r.of({TfToken("st"), TfToken("st"), TfToken("uv"), TfToken("other")});
    const UsdGeomPrimvar held = api.GetPrimvar(name);
    if (held && r.chance(0.25)) {
        UsdPrim(mesh.GetPrim()).RemoveProperty(held.GetName());
        return "remove " + mesh.GetPath().GetString() + "." + held.GetName().GetString();
    }
    const TfToken interpolation = r.of({UsdGeomTokens->vertex, UsdGeomTokens->varying, UsdGeomTokens->faceVarying});
    VtVec2fArray values;
    for (int i = valueCount(mesh, interpolation, r); i > 0; --i) {
        const GfVec3f v = r.vec(0, 1);
        values.push_back({v[0], v[1]});
    }
    UsdGeomPrimvar primvar = api.CreatePrimvar(name, SdfValueTypeNames->TexCoord2fArray, interpolation);
    primvar.SetInterpolation(interpolation);
    std::string indexed;
    if (r.chance(0.2)) {
        VtIntArray indices(values.size());
        for (int& i : indices) {
            i = r.below(int(values.size()));
        }
        primvar.SetIndices(indices);
        indexed = ", indexed";
    } else if (primvar.IsIndexed()) {
        primvar.BlockIndices();
    }
    return setAttribute(mesh.GetPrim(), primvar.GetName().GetString(), SdfValueTypeNames->TexCoord2fArray,
                        VtValue(values), r) +
           " (" + interpolation.GetString() + indexed + ")";
}

std::string setOther(const UsdGeomMesh& mesh, Random& r) {
    return setVectors(mesh, "wind", SdfValueTypeNames->Vector3fArray, -1, 1, r);
}

std::string setDoubleSided(const UsdGeomMesh& mesh, Random& r) {
    return setAttribute(mesh.GetPrim(), "doubleSided", SdfValueTypeNames->Bool, VtValue(r.chance(0.5)), r, false);
}

std::string refine(Session& s, Random& r) {
    const UsdGeomMesh mesh = anyMesh(s, r);
    if (!mesh || r.chance(0.3)) {
        s.view.refineFallback = r.below(3);
        return "refine all by " + std::to_string(s.view.refineFallback);
    }
    if (isInstanced(mesh.GetPrim()) || mesh.GetPrim().GetParent().IsA<UsdGeomPointInstancer>()) {
        return {}; // UsdImaging knows them by other paths
    }
    s.view.refine[mesh.GetPath()] = r.below(3);
    return "refine " + mesh.GetPath().GetString() + " by " + std::to_string(s.view.refine[mesh.GetPath()]);
}

/// Anything that has a place: meshes, lights, groups, instances.
std::string move(Session& s, Random& r) {
    const UsdPrim prim = anyOf(s.prims<UsdGeomXformable>(), r);
    if (!prim || prim.IsA<UsdGeomCamera>()) {
        return {};
    }
    const bool sampled = r.chance(0.25);
    const UsdTimeCode time = sampled ? UsdTimeCode(1 + r.below(3)) : UsdTimeCode::Default();
    if (r.chance(0.1)) {
        UsdGeomXformable(prim).ClearXformOpOrder();
        return "no transform for " + prim.GetPath().GetString();
    }
    if (!sampled && r.chance(0.5)) {
        prim.GetAttribute(TfToken("xformOp:transform")).Clear();
    }
    placeAt(prim, randomPlace(r), time);
    return "move " + prim.GetPath().GetString() + (sampled ? " at time " + TfStringify(time) : "");
}

std::string setVisibility(Session& s, Random& r) {
    const UsdPrim prim = anyOf(s.prims<UsdGeomImageable>(), r);
    return prim ? setAttribute(prim, "visibility", SdfValueTypeNames->Token,
                               VtValue(r.of({UsdGeomTokens->invisible, UsdGeomTokens->inherited})), r)
                : std::string();
}

std::string setPurpose(Session& s, Random& r) {
    const UsdPrim prim = anyOf(s.prims<UsdGeomImageable>(), r);
    return prim ? setAttribute(prim, "purpose", SdfValueTypeNames->Token,
                               VtValue(r.of({UsdGeomTokens->default_, UsdGeomTokens->render, UsdGeomTokens->proxy,
                                             UsdGeomTokens->guide})),
                               r, false)
                : std::string();
}

std::string activate(Session& s, Random& r) {
    std::vector<UsdPrim> prims;
    for (const char* parent : {"/World", "/Looks"}) {
        for (const UsdPrim& prim : s.stage->GetPrimAtPath(SdfPath(parent)).GetAllChildren()) {
            prims.push_back(prim);
        }
    }
    const UsdPrim prim = anyOf(prims, r);
    if (!prim) {
        return {};
    }
    const bool active = !prim.IsActive() || r.chance(0.3);
    prim.SetActive(active);
    return std::string(active ? "activate " : "deactivate ") + prim.GetPath().GetString();
}

std::string group(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/World", "Group", r);
    const UsdPrim prim = anyOf(s.prims<UsdGeomMesh>(), r);
    if (path.IsEmpty() || !prim || prim.GetParent().GetPath() != SdfPath("/World")) {
        return {};
    }
    const UsdGeomXform xform = UsdGeomXform::Define(s.stage, path);
    placeAt(xform.GetPrim(), randomPlace(r), UsdTimeCode::Default());
    SdfBatchNamespaceEdit edit;
    edit.Add(prim.GetPath(), path.AppendChild(prim.GetName()));
    const std::string name = prim.GetPath().GetString();
    s.stage->GetRootLayer()->Apply(edit);
    return "put " + name + " into " + path.GetString();
}

} // namespace

void addMeshEdits(EditKinds& kinds) {
    kinds.push_back({"mesh: add", 6, addMesh});
    kinds.push_back({"mesh: remove", 2, [](Session& s, Random& r) { return removePrim(s, anyMesh(s, r).GetPrim()); }});
    kinds.push_back(
        {"mesh: rename", 2, [](Session& s, Random& r) { return renamePrim(s, anyMesh(s, r).GetPrim(), r); }});
    kinds.push_back({"mesh: points", 4, ofMesh(movePoints)});
    kinds.push_back({"mesh: topology", 3, ofMesh(retopologise)});
    kinds.push_back({"mesh: no faces", 1, ofMesh(empty)});
    kinds.push_back({"mesh: scheme", 3, ofMesh(setScheme)});
    kinds.push_back({"mesh: orientation", 2, ofMesh(setOrientation)});
    kinds.push_back({"mesh: subdivision tags, holes", 3, ofMesh(setTags)});
    kinds.push_back({"mesh: displayColor", 4, ofMesh(setColor)});
    kinds.push_back({"mesh: normals", 4, ofMesh(setNormals)});
    kinds.push_back({"mesh: texture coordinates", 4, ofMesh(setUvs)});
    kinds.push_back({"mesh: another primvar", 2, ofMesh(setOther)});
    kinds.push_back({"mesh: double-sided", 1, ofMesh(setDoubleSided)});
    kinds.push_back({"mesh: refine level", 3, refine});
    kinds.push_back({"prim: transform", 8, move});
    kinds.push_back({"prim: visibility", 5, setVisibility});
    kinds.push_back({"prim: purpose", 4, setPurpose});
    kinds.push_back({"prim: activation", 2, activate});
    kinds.push_back({"prim: into a group", 2, group});
}

} // namespace fuzz
