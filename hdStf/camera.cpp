// SPDX-License-Identifier: Apache-2.0
#include "hdStf/camera.h"

#include "hdStf/conversions.h"
#include "hdStf/hydraCompat.h"
#include "hdStf/motionSamples.h"
#include "hdStf/renderParam.h"

#include "pxr/base/gf/frustum.h"
#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/sceneDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

double _Number(HdSceneDelegate* sceneDelegate, SdfPath const& id, TfToken const& name) {
    const VtValue value = VtValue::Cast<double>(sceneDelegate->GetCameraParamValue(id, name));
    return value.IsEmpty() || !std::isfinite(value.UncheckedGet<double>()) ? 0.0 : value.UncheckedGet<double>();
}

} // namespace

void HdStfCamera::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
    const bool dirty = *dirtyBits != Clean;
    HdCamera::Sync(sceneDelegate, renderParam, dirtyBits);
    if (!dirty) {
        return;
    }
    _PullOptics(sceneDelegate);
    // Prims sync after the cameras.
    static_cast<HdStfRenderParam*>(renderParam)->SetShutter(GetId(), _optics.shutter);
    _PullMotion(sceneDelegate);
}

void HdStfCamera::Finalize(HdRenderParam* renderParam) {
    static_cast<HdStfRenderParam*>(renderParam)->SetShutter(GetId(), {});
    HdCamera::Finalize(renderParam);
}

void HdStfCamera::_PullOptics(HdSceneDelegate* sceneDelegate) {
    SdfPath const& id = GetId();
    const double fStop = _Number(sceneDelegate, id, HdCameraTokens->fStop);
    const double focalLength = _Number(sceneDelegate, id, HdCameraTokens->focalLength);
    _optics.lens = {fStop > 0 ? focalLength / (2 * fStop) : 0.0,
                    _Number(sceneDelegate, id, HdCameraTokens->focusDistance)};
    _optics.shutter = {_Number(sceneDelegate, id, HdCameraTokens->shutterOpen),
                       _Number(sceneDelegate, id, HdCameraTokens->shutterClose)};
    // Of the schema from 20.11 on; before, the attribute of that name.
    _optics.exposure = _Number(sceneDelegate, id, TfToken("exposure"));
}

void HdStfCamera::_PullMotion(HdSceneDelegate* sceneDelegate) {
    _optics.viewToWorld.clear();
    if (!_optics.shutter.blurs()) {
        return;
    }
    for (auto const& [time, matrix] : HdStfSampleTransform(sceneDelegate, GetId(), _optics.shutter)) {
        // As UsdImaging makes the view matrix: scale and shear of the prim are none of the camera's.
        GfFrustum frustum;
        frustum.SetPositionAndRotationFromMatrix(matrix);
        _optics.viewToWorld.push_back({time, HdStfToTransform(frustum.ComputeViewInverse())});
    }
    if (_optics.viewToWorld.size() < 2) {
        _optics.viewToWorld.clear();
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
