// SPDX-License-Identifier: Apache-2.0
// Sees OpenUSD, and so its TBB: no header that leads to OpenVDB or TBB may come in here.
#include "tools/stf/usd_mesh_reader.h"

#include "stfLib/surface/refined_surface.h"

#include <filesystem>
#include <pxr/base/tf/errorMark.h>
#include <pxr/usd/usd/primRange.h>
#include <pxr/usd/usd/stage.h>
#include <pxr/usd/usdGeom/imageable.h>
#include <pxr/usd/usdGeom/mesh.h>
#include <pxr/usd/usdGeom/metrics.h>
#include <pxr/usd/usdGeom/pointInstancer.h>
#include <pxr/usd/usdGeom/xformCache.h>
#include <pxr/usd/usdShade/material.h>
#include <pxr/usd/usdShade/materialBindingAPI.h>

namespace stf {

namespace {

using namespace PXR_NS;

/// Each level makes four triangles of one: this many are round at the size of a tile.
constexpr int kSubdivisionLevel = 3;
constexpr std::size_t kMaxTriangles = 4'000'000;

UsdStageRefPtr open(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) {
        throw Error(path + ": no such file");
    }
    TfErrorMark mark;
    UsdStageRefPtr stage = UsdStage::Open(path);
    if (!stage) {
        std::string why;
        for (auto e = mark.GetBegin(); e != mark.GetEnd() && why.empty(); ++e) {
            why = e->GetCommentary();
        }
        mark.Clear();
        std::replace(why.begin(), why.end(), '\n', ' ');
        throw Error(path + ": is not a readable USD file" + (why.empty() ? "" : " (" + why + ")"));
    }
    mark.Clear();
    return stage;
}

ControlMesh controlMeshOf(const UsdGeomMesh& mesh, const std::string& name) {
    const UsdTimeCode time = UsdTimeCode::EarliestTime();
    ControlMesh result;
    VtVec3fArray points;
    VtIntArray counts, indices, holes;
    TfToken scheme, orientation;
    mesh.GetPointsAttr().Get(&points, time);
    mesh.GetFaceVertexCountsAttr().Get(&counts, time);
    mesh.GetFaceVertexIndicesAttr().Get(&indices, time);
    mesh.GetHoleIndicesAttr().Get(&holes, time);
    mesh.GetSubdivisionSchemeAttr().Get(&scheme);
    mesh.GetOrientationAttr().Get(&orientation);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const GfVec3f& p = points[i];
        result.points.push_back({p[0], p[1], p[2]});
        if (!isFinite(result.points.back())) {
            throw Error(name + ": vertex " + std::to_string(i) + " is not finite");
        }
    }
    result.faceVertexCounts.assign(counts.begin(), counts.end());
    result.faceVertexIndices.assign(indices.begin(), indices.end());
    result.holeIndices.assign(holes.begin(), holes.end());
    result.scheme = scheme == UsdGeomTokens->catmullClark ? ControlMesh::Scheme::CatmullClark
                    : scheme == UsdGeomTokens->loop       ? ControlMesh::Scheme::Loop
                    : scheme == UsdGeomTokens->bilinear   ? ControlMesh::Scheme::Bilinear
                                                          : ControlMesh::Scheme::None;
    result.leftHanded = orientation == UsdGeomTokens->leftHanded;
    VtIntArray lengths, creases, corners;
    VtFloatArray sharpness, cornerSharpness;
    mesh.GetCreaseIndicesAttr().Get(&creases, time);
    mesh.GetCreaseLengthsAttr().Get(&lengths, time);
    mesh.GetCreaseSharpnessesAttr().Get(&sharpness, time);
    mesh.GetCornerIndicesAttr().Get(&corners, time);
    mesh.GetCornerSharpnessesAttr().Get(&cornerSharpness, time);
    result.creaseIndices.assign(creases.begin(), creases.end());
    result.creaseLengths.assign(lengths.begin(), lengths.end());
    result.creaseSharpnesses.assign(sharpness.begin(), sharpness.end());
    result.cornerIndices.assign(corners.begin(), corners.end());
    result.cornerSharpnesses.assign(cornerSharpness.begin(), cornerSharpness.end());
    TfToken boundary;
    if (mesh.GetInterpolateBoundaryAttr().Get(&boundary)) {
        result.interpolateBoundary = boundary.GetString();
    }
    return result;
}

MeshPart partOf(const UsdGeomMesh& mesh, const Transform& toMm, const std::string& file, const MessageSink& messages) {
    MeshPart part;
    part.name = mesh.GetPrim().GetName().GetString();
    part.path = mesh.GetPath().GetString();
    const std::string name = file + ": " + part.path;
    if (const UsdShadeMaterial m = UsdShadeMaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()) {
        part.material = m.GetPrim().GetName().GetString();
    }
    ControlMesh control = controlMeshOf(mesh, name);
    try {
        const std::string mended = sanitize(control).summary();
        if (!mended.empty()) {
            report(messages, Severity::Info, name + ": " + mended);
        }
        RefineOptions options;
        options.level = control.scheme == ControlMesh::Scheme::None ? 0 : kSubdivisionLevel;
        options.maxTriangles = kMaxTriangles;
        const RefinedSurface surface = refine(control, options, messages);
        part.mesh.triangles = surface.triangles;
        for (const Vec3f& p : surface.points) {
            part.mesh.points.push_back(Vec3d(p));
        }
    } catch (const Error& e) {
        throw Error(name + ": " + e.what());
    }
    part.mesh = transformed(part.mesh, toMm);
    return part;
}

/// From the stage's world to mm with z up.
Transform stageToMm(const UsdStageRefPtr& stage) {
    const double mm = 1000 * UsdGeomGetStageMetersPerUnit(stage);
    Transform t;
    t.x = {mm, 0, 0};
    t.y = UsdGeomGetStageUpAxis(stage) == UsdGeomTokens->y ? Vec3d(0, 0, mm) : Vec3d(0, mm, 0);
    t.z = UsdGeomGetStageUpAxis(stage) == UsdGeomTokens->y ? Vec3d(0, -mm, 0) : Vec3d(0, 0, mm);
    return t;
}

} // namespace

std::vector<MeshPart> readUsdMeshes(const std::string& path, const MessageSink& messages) {
    const UsdStageRefPtr stage = open(path);
    UsdGeomXformCache transforms(UsdTimeCode::EarliestTime());
    const Transform toMm = stageToMm(stage);
    std::vector<MeshPart> parts;
    std::size_t others = 0;
    for (const UsdPrim& prim : UsdPrimRange(stage->GetPseudoRoot(), UsdTraverseInstanceProxies())) {
        const UsdGeomImageable imageable(prim);
        if (imageable && (imageable.ComputeVisibility(UsdTimeCode::EarliestTime()) == UsdGeomTokens->invisible ||
                          imageable.ComputePurpose() == UsdGeomTokens->proxy ||
                          imageable.ComputePurpose() == UsdGeomTokens->guide)) {
            continue;
        }
        const UsdGeomMesh mesh(prim);
        if (mesh) {
            const GfMatrix4d world = transforms.GetLocalToWorldTransform(prim);
            parts.push_back(partOf(mesh, compose(toMm, Transform::fromRowMajor(world.GetArray())), path, messages));
        } else if (UsdGeomGprim(prim) || UsdGeomPointInstancer(prim)) {
            ++others;
        }
    }
    if (others) {
        report(messages, Severity::Warning,
               path + ": " + std::to_string(others) +
                   " prims that are not meshes (spheres, curves, instancers) are left out");
    }
    if (parts.empty()) {
        throw Error(path + ": holds no visible mesh");
    }
    return parts;
}

} // namespace stf
