// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "pxr/usd/usdGeom/basisCurves.h"
#include "pxr/usd/usdGeom/points.h"
#include "pxr/usd/usdGeom/tokens.h"

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

namespace {

/// Two curves of 4 and 7 points: right for every basis, and of every interpolation another number of values. A closed
/// cubic has as many varying values as points, so that none is closed.
constexpr int curveCount = 2, pointCount = 11;

UsdGeomBasisCurves anyCurves(const Session& s, Random& r) {
    return UsdGeomBasisCurves(anyOf(s.prims<UsdGeomBasisCurves>(), r));
}

UsdGeomPoints anyPoints(const Session& s, Random& r) {
    return UsdGeomPoints(anyOf(s.prims<UsdGeomPoints>(), r));
}

VtVec3fArray randomPoints(int count, Random& r) {
    VtVec3fArray points;
    for (int i = 0; i < count; ++i) {
        points.push_back(r.vec(-1, 1));
    }
    return points;
}

VtFloatArray randomWidths(int count, Random& r) {
    VtFloatArray widths;
    for (int i = count - (count > 2 && r.chance(0.05) ? 1 : 0); i > 0; --i) { // of two, one would be a constant
        widths.push_back(r.of({0.05f, 0.2f, 0.4f}));
    }
    return widths;
}

std::string addCurves(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/World", "Curves", r);
    if (path.IsEmpty() || s.prims<UsdGeomBasisCurves>().size() > 2) {
        return {};
    }
    UsdGeomBasisCurves curves = UsdGeomBasisCurves::Define(s.stage, path);
    curves.GetTypeAttr().Set(r.of({UsdGeomTokens->linear, UsdGeomTokens->cubic}));
    curves.GetCurveVertexCountsAttr().Set(VtIntArray{4, 7});
    curves.GetPointsAttr().Set(randomPoints(pointCount, r));
    curves.GetWidthsAttr().Set(VtFloatArray{0.3f});
    curves.SetWidthsInterpolation(UsdGeomTokens->constant);
    placeAt(curves.GetPrim(), randomPlace(r), UsdTimeCode::Default());
    return "add " + path.GetString();
}

std::string addPoints(Session& s, Random& r) {
    const SdfPath path = freePath(s, "/World", "Points", r);
    if (path.IsEmpty() || s.prims<UsdGeomPoints>().size() > 2) {
        return {};
    }
    UsdGeomPoints points = UsdGeomPoints::Define(s.stage, path);
    points.GetPointsAttr().Set(randomPoints(2 + r.below(4), r));
    points.GetWidthsAttr().Set(VtFloatArray{0.5f});
    points.SetWidthsInterpolation(UsdGeomTokens->constant);
    placeAt(points.GetPrim(), randomPlace(r), UsdTimeCode::Default());
    return "add " + path.GetString();
}

std::string setCurvePoints(Session& s, Random& r) {
    const UsdGeomBasisCurves curves = anyCurves(s, r);
    return curves ? setAttribute(curves.GetPrim(), "points", SdfValueTypeNames->Point3fArray,
                                 VtValue(randomPoints(pointCount - (r.chance(0.05) ? 1 : 0), r)), r)
                  : std::string();
}

std::string setPointPoints(Session& s, Random& r) {
    const UsdGeomPoints points = anyPoints(s, r);
    return points ? setAttribute(points.GetPrim(), "points", SdfValueTypeNames->Point3fArray,
                                 VtValue(randomPoints(r.below(6), r)), r)
                  : std::string();
}

std::string setBasis(Session& s, Random& r) {
    const UsdGeomBasisCurves curves = anyCurves(s, r);
    if (!curves) {
        return {};
    }
    return r.chance(0.5)
               ? setAttribute(curves.GetPrim(), "type", SdfValueTypeNames->Token,
                              VtValue(r.of({UsdGeomTokens->linear, UsdGeomTokens->cubic})), r, false)
               : setAttribute(curves.GetPrim(), "basis", SdfValueTypeNames->Token,
                              VtValue(r.of({UsdGeomTokens->bezier, UsdGeomTokens->bspline, UsdGeomTokens->catmullRom})),
                              r, false);
}

std::string setCounts(Session& s, Random& r) {
    const UsdGeomBasisCurves curves = anyCurves(s, r);
    return curves
               ? setAttribute(
                     curves.GetPrim(), "curveVertexCounts", SdfValueTypeNames->IntArray,
                     VtValue(r.of({VtIntArray{4, 7}, VtIntArray{4, 7}, VtIntArray{4}, VtIntArray{400}, VtIntArray{}})),
                     r, false)
               : std::string();
}

std::string setCurveWidths(Session& s, Random& r) {
    const UsdGeomBasisCurves curves = anyCurves(s, r);
    if (!curves) {
        return {};
    }
    const TfToken interpolation = r.of({UsdGeomTokens->constant, UsdGeomTokens->uniform, UsdGeomTokens->vertex});
    UsdGeomBasisCurves(curves).SetWidthsInterpolation(interpolation);
    curves.GetWidthsAttr().Clear(); // samples of other times have other numbers
    const int count = interpolation == UsdGeomTokens->constant  ? 1
                      : interpolation == UsdGeomTokens->uniform ? curveCount
                                                                : pointCount;
    return setAttribute(curves.GetPrim(), "widths", SdfValueTypeNames->FloatArray, VtValue(randomWidths(count, r)), r) +
           " (" + interpolation.GetString() + ")";
}

std::string setPointWidths(Session& s, Random& r) {
    const UsdGeomPoints points = anyPoints(s, r);
    if (!points) {
        return {};
    }
    VtVec3fArray held;
    points.GetPointsAttr().Get(&held, UsdTimeCode::EarliestTime());
    const bool each = r.chance(0.5);
    points.GetWidthsAttr().Clear();
    UsdGeomPoints(points).SetWidthsInterpolation(each ? UsdGeomTokens->vertex : UsdGeomTokens->constant);
    return setAttribute(points.GetPrim(), "widths", SdfValueTypeNames->FloatArray,
                        VtValue(randomWidths(each ? int(held.size()) : 1, r)), r);
}

std::string setColor(Session& s, Random& r) {
    const UsdPrim prim = r.chance(0.5) ? anyCurves(s, r).GetPrim() : anyPoints(s, r).GetPrim();
    return prim ? setAttribute(prim, "primvars:displayColor", SdfValueTypeNames->Color3fArray,
                               VtValue(VtVec3fArray{r.vec(0, 1)}), r)
                : std::string();
}

/// Ribbons in place of tubes, and back.
std::string setNormals(Session& s, Random& r) {
    const UsdGeomBasisCurves curves = anyCurves(s, r);
    if (!curves) {
        return {};
    }
    if (curves.GetNormalsAttr().HasAuthoredValue() && r.chance(0.5)) {
        UsdPrim(curves.GetPrim()).RemoveProperty(UsdGeomTokens->normals);
        return "remove " + curves.GetPath().GetString() + ".normals";
    }
    UsdGeomBasisCurves(curves).SetNormalsInterpolation(UsdGeomTokens->vertex);
    return setAttribute(curves.GetPrim(), "normals", SdfValueTypeNames->Normal3fArray,
                        VtValue(randomPoints(pointCount, r)), r);
}

} // namespace

void addGprimEdits(EditKinds& kinds) {
    kinds.push_back({"curves: add", 2, addCurves});
    kinds.push_back(
        {"curves: remove", 1, [](Session& s, Random& r) { return removePrim(s, anyCurves(s, r).GetPrim()); }});
    kinds.push_back({"curves: points", 2, setCurvePoints});
    kinds.push_back({"curves: basis", 2, setBasis});
    kinds.push_back({"curves: counts", 1, setCounts});
    kinds.push_back({"curves: widths", 2, setCurveWidths});
    kinds.push_back({"curves: normals", 1, setNormals});
    kinds.push_back({"points: add", 2, addPoints});
    kinds.push_back(
        {"points: remove", 1, [](Session& s, Random& r) { return removePrim(s, anyPoints(s, r).GetPrim()); }});
    kinds.push_back({"points: points", 2, setPointPoints});
    kinds.push_back({"points: widths", 2, setPointWidths});
    kinds.push_back({"curves, points: displayColor", 2, setColor});
}

} // namespace fuzz
