// SPDX-License-Identifier: Apache-2.0
#include "edit_tools.h"

#include "pxr/base/gf/rotation.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/usd/sdf/namespaceEdit.h"
#include "pxr/usd/usdGeom/tokens.h"
#include "pxr/usd/usdGeom/xformable.h"

#include <cmath>

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

Shape randomShape(Random& random) {
    Shape s;
    const float size = random.of({0.4f, 0.8f, 1.2f});
    switch (random.below(4)) {
    case 0:
        s.name = "strip";
        s.points = {{-size, -size, 0}, {0, -size, 0}, {size, -size, 0},
                    {-size, size, 0},  {0, size, 0},  {size, size, 0}};
        s.counts = {4, 4};
        s.indices = {0, 1, 4, 3, 1, 2, 5, 4};
        break;
    case 1:
        s.name = "cube";
        for (int i = 0; i < 8; ++i) {
            s.points.push_back({i & 1 ? size : -size, i & 2 ? size : -size, i & 4 ? size : -size});
        }
        s.counts.assign(6, 4);
        s.indices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
        break;
    case 2:
        s.name = "octahedron";
        s.points = {{size, 0, 0}, {-size, 0, 0}, {0, size, 0}, {0, -size, 0}, {0, 0, size}, {0, 0, -size}};
        s.counts.assign(8, 3);
        s.indices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
        break;
    default:
        s.name = "grid";
        for (int i = 0; i < 16; ++i) {
            s.points.push_back({size * float(i % 4 - 1.5), size * float(i / 4 - 1.5), size * random.of({0.f, 0.2f})});
        }
        for (int i = 0; i < 9; ++i) {
            const int k = i / 3 * 4 + i % 3;
            s.counts.push_back(4);
            for (const int corner : {k, k + 1, k + 5, k + 4}) {
                s.indices.push_back(corner);
            }
        }
    }
    return s;
}

SdfPath freePath(const Session& session, const char* parent, const char* prefix, Random& random) {
    const SdfPath path(std::string(parent) + "/" + prefix + std::to_string(random.below(100)));
    return session.stage->GetPrimAtPath(path) ? SdfPath() : path;
}

void author(const UsdGeomMesh& mesh, const Shape& shape) {
    mesh.GetPointsAttr().Set(shape.points);
    mesh.GetFaceVertexCountsAttr().Set(shape.counts);
    mesh.GetFaceVertexIndicesAttr().Set(shape.indices);
}

GfMatrix4d randomPlace(Random& random) {
    GfMatrix4d scale(1), turn(1), move(1);
    scale.SetScale(GfVec3d(random.of({0.5f, 1.0f, 1.0f, 1.4f})));
    turn.SetRotate(GfRotation(GfVec3d(random.vec(-1, 1)) + GfVec3d(0, 0, 1e-3), 30.0 * random.below(12)));
    move.SetTranslate(GfVec3d(random.vec(-2, 2)));
    return scale * turn * move;
}

void placeAt(const UsdPrim& prim, const GfMatrix4d& place, UsdTimeCode time) {
    const UsdGeomXformable xformable(prim);
    bool resets = false;
    const std::vector<UsdGeomXformOp> ops = xformable.GetOrderedXformOps(&resets);
    const bool isMatrix = ops.size() == 1 && ops[0].GetOpType() == UsdGeomXformOp::TypeTransform;
    (isMatrix ? ops[0] : xformable.MakeMatrixXform()).Set(place, time);
}

std::string setAttribute(const UsdPrim& prim, const std::string& name, const SdfValueTypeName& type,
                         const VtValue& value, Random& random, bool mayVary) {
    const UsdAttribute attribute = prim.CreateAttribute(TfToken(name), type);
    const bool sampled = mayVary && random.chance(0.15);
    const double time = 1 + random.below(3);
    if (mayVary && random.chance(0.1)) {
        attribute.Clear(); // of time samples too
    }
    attribute.Set(value, sampled ? UsdTimeCode(time) : UsdTimeCode::Default());
    return attribute.GetPath().GetString() + " = " + TfStringify(value) +
           (sampled ? " at time " + TfStringify(time) : "");
}

TfToken randomInterpolation(Random& random) {
    return random.of({UsdGeomTokens->constant, UsdGeomTokens->uniform, UsdGeomTokens->varying, UsdGeomTokens->vertex,
                      UsdGeomTokens->faceVarying});
}

int valueCount(const UsdGeomMesh& mesh, const TfToken& interpolation, Random& random) {
    VtVec3fArray points;
    VtIntArray counts, indices;
    mesh.GetPointsAttr().Get(&points, UsdTimeCode::EarliestTime());
    mesh.GetFaceVertexCountsAttr().Get(&counts, UsdTimeCode::EarliestTime());
    mesh.GetFaceVertexIndicesAttr().Get(&indices, UsdTimeCode::EarliestTime());
    const size_t count = interpolation == UsdGeomTokens->constant      ? 1
                         : interpolation == UsdGeomTokens->uniform     ? counts.size()
                         : interpolation == UsdGeomTokens->faceVarying ? indices.size()
                                                                       : points.size();
    return std::max(1, int(count)) - (count > 2 && random.chance(0.05) ? 1 : 0); // of two, one would be a constant
}

bool isInstanced(const UsdPrim& prim) {
    return prim.GetPath().HasPrefix(SdfPath("/Library"));
}

std::string removePrim(Session& session, const UsdPrim& prim) {
    if (!prim || isInstanced(prim)) {
        return {};
    }
    const SdfPath path = prim.GetPath();
    session.stage->RemovePrim(path);
    return "remove " + path.GetString();
}

std::string renamePrim(Session& session, const UsdPrim& prim, Random& random) {
    if (!prim || isInstanced(prim)) {
        return {};
    }
    const SdfPath from = prim.GetPath();
    const SdfPath to = from.ReplaceName(TfToken("R" + std::to_string(random.below(100))));
    if (session.stage->GetPrimAtPath(to)) {
        return {};
    }
    SdfBatchNamespaceEdit edit;
    edit.Add(from, to);
    session.stage->GetRootLayer()->Apply(edit);
    return "rename " + from.GetString() + " to " + to.GetName();
}

} // namespace fuzz
