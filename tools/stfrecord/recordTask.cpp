// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/recordTask.h"

#include "hdStf/hydraCompat.h"

#include "pxr/imaging/hd/camera.h"
#include "pxr/imaging/hd/renderBuffer.h"
#include "pxr/imaging/hd/renderDelegate.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/rprimCollection.h"
#include "pxr/imaging/hd/tokens.h"

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

RecordTask::RecordTask(HdRenderIndex& index, HdRenderPassAovBindingVector bindings, int width, int height,
                       TfTokenVector renderTags)
    : HdTask(SdfPath()), bindings_(std::move(bindings)), renderTags_(std::move(renderTags)), width_(width),
      height_(height) {
    HdRenderDelegate* delegate = index.GetRenderDelegate();
    const HdRprimCollection everything(HdTokens->geometry, HdReprSelector(HdReprTokens->refined),
                                       SdfPath::AbsoluteRootPath());
    pass_ = delegate->CreateRenderPass(&index, everything);
    state_ = delegate->CreateRenderPassState();
}

void RecordTask::Sync(HdSceneDelegate*, HdTaskContext*, HdDirtyBits* dirtyBits) {
    pass_->Sync();
    *dirtyBits = HdChangeTracker::Clean;
}

void RecordTask::Prepare(HdTaskContext*, HdRenderIndex* index) {
    const auto* camera = static_cast<const HdCamera*>(index->GetSprim(HdPrimTypeTokens->camera, camera_));
    if (camera) {
#if HDSTF_HAS_SET_FRAMING
        const GfRect2i window(GfVec2i(0), width_, height_);
        state_->SetFraming(CameraUtilFraming(GfRange2f(GfVec2f(0), GfVec2f(float(width_), float(height_))), window,
                                             pixelAspectRatio_));
        state_->SetCamera(camera);
#else
        state_->SetCameraAndViewport(camera, GfVec4d(0, 0, width_, height_));
#endif
    }
    for (HdRenderPassAovBinding& binding : bindings_) {
        binding.renderBuffer =
            static_cast<HdRenderBuffer*>(index->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId));
    }
    state_->SetAovBindings(bindings_);
    state_->Prepare(index->GetResourceRegistry());
#if HDSTF_HAS_PASS_PREPARE
    pass_->Prepare(renderTags_);
#endif
}

void RecordTask::Execute(HdTaskContext*) {
#if HDSTF_HAS_PASS_STATE_BIND
    state_->Bind();
    pass_->Execute(state_, renderTags_);
    state_->Unbind();
#else
    pass_->Execute(state_, renderTags_);
#endif
}

} // namespace stfrecord
