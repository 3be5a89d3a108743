// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/stageCamera.h"

#include "pxr/base/gf/camera.h"
#include "pxr/usd/usd/editContext.h"
#include "pxr/usd/usd/primRange.h"
#include "pxr/usd/usdGeom/bboxCache.h"
#include "pxr/usd/usdGeom/camera.h"
#include "pxr/usd/usdGeom/metrics.h"
#include "pxr/usd/usdGeom/tokens.h"

#include <algorithm>
#include <cmath>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

SdfPathVector findCameras(const UsdStagePtr& stage) {
    SdfPathVector cameras;
    for (const UsdPrim& prim : stage->Traverse()) {
        if (prim.IsA<UsdGeomCamera>()) {
            cameras.push_back(prim.GetPath());
        }
    }
    return cameras;
}

SdfPath findCamera(const UsdStagePtr& stage, const std::string& name) {
    const SdfPathVector cameras = findCameras(stage);
    const auto it = std::find_if(cameras.begin(), cameras.end(), [&name](const SdfPath& path) {
        return name.empty() || path.GetString() == name || path.GetName() == name;
    });
    return it == cameras.end() ? SdfPath() : *it;
}

SdfPath defineFramingCamera(const UsdStagePtr& stage, UsdTimeCode time, const std::vector<std::string>& purposes) {
    TfTokenVector tokens;
    for (const std::string& purpose : purposes) {
        tokens.emplace_back(purpose);
    }
    UsdGeomBBoxCache boxes(time, tokens);
    const GfRange3d range = boxes.ComputeWorldBound(stage->GetPseudoRoot()).ComputeAlignedRange();
    const GfVec3d center = range.IsEmpty() ? GfVec3d(0.0) : range.GetMidpoint();
    const double diagonal = range.IsEmpty() ? 0.0 : range.GetSize().GetLength();
    const double radius = diagonal > 0 && std::isfinite(diagonal) ? diagonal / 2 : 1.0;

    constexpr double fieldOfView = 35; // degrees, of the shorter side
    constexpr double margin = 1.05;
    const double distance = margin * radius / std::sin(fieldOfView * M_PI / 360);
    const bool zUp = UsdGeomGetStageUpAxis(stage) == UsdGeomTokens->z;
    const GfVec3d eye = center + distance * (zUp ? GfVec3d(0, -1, 0) : GfVec3d(0, 0, 1));
    const GfVec3d up = zUp ? GfVec3d(0, 0, 1) : GfVec3d(0, 1, 0);

    GfCamera camera;
    camera.SetTransform(GfMatrix4d(1.0).SetLookAt(eye, center, up).GetInverse());
    camera.SetPerspectiveFromAspectRatioAndFieldOfView(16.0f / 9.0f, fieldOfView, GfCamera::FOVVertical);
    camera.SetClippingRange(
        GfRange1f(float(std::max(distance - 2 * radius, distance * 1e-3)), float(distance + 2 * radius)));

    SdfPath path("/stfrecordCamera");
    while (stage->GetPrimAtPath(path)) {
        path = SdfPath(path.GetString() + "_");
    }
    UsdEditContext context(stage, stage->GetSessionLayer());
    UsdGeomCamera::Define(stage, path).SetFromCamera(camera, UsdTimeCode::Default());
    return path;
}

int imageHeight(const UsdStagePtr& stage, const SdfPath& path, UsdTimeCode time, int width) {
    const UsdGeomCamera camera(stage->GetPrimAtPath(path));
    const float aspect = camera ? camera.GetCamera(time).GetAspectRatio() : 1.0f;
    constexpr int largest = 32768;
    if (!(aspect > 0) || !std::isfinite(aspect)) {
        return width;
    }
    return int(std::clamp(std::lround(double(width) / double(aspect)), 1L, long(largest)));
}

} // namespace stfrecord
