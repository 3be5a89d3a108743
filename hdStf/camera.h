// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/camera.h"

#include "pxr/imaging/hd/camera.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfCamera
///
/// Hydra's camera with what a film sees beside its matrices: lens, shutter, exposure, and its way while the shutter is
/// open.
///
/// Threading: as for every sprim. The render pass reads it while nothing syncs.
class HdStfCamera final : public HdCamera {
public:
    explicit HdStfCamera(SdfPath const& id) : HdCamera(id) {}
    ~HdStfCamera() override = default;

    /// Lengths in scene units, times in frames from the present one.
    stf::CameraOptics const& GetOptics() const { return _optics; }

    void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;
    HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }

private:
    void _PullOptics(HdSceneDelegate* sceneDelegate);
    void _PullMotion(HdSceneDelegate* sceneDelegate);

    stf::CameraOptics _optics;
};

PXR_NAMESPACE_CLOSE_SCOPE
