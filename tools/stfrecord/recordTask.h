// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/imaging/hd/aov.h"
#include "pxr/imaging/hd/renderPass.h"
#include "pxr/imaging/hd/renderPassState.h"
#include "pxr/imaging/hd/task.h"

namespace stfrecord {

/// The one task of the recorder: draws everything with one of the render tags into the bound AOV buffers.
class RecordTask final : public PXR_NS::HdTask {
public:
    RecordTask(PXR_NS::HdRenderIndex& index, PXR_NS::HdRenderPassAovBindingVector bindings, int width, int height,
               PXR_NS::TfTokenVector renderTags);

    void setCamera(const PXR_NS::SdfPath& camera) { camera_ = camera; }
    /// Other buffers, and another size of the frame, for the same pass.
    void setOutputs(PXR_NS::HdRenderPassAovBindingVector bindings, int width, int height) {
        bindings_ = std::move(bindings);
        width_ = width;
        height_ = height;
    }
    /// Width over height of a pixel. Versions without framing leave that to the camera's aperture and window policy.
    void setPixelAspectRatio(float ratio) { pixelAspectRatio_ = ratio; }
    void setRenderTags(PXR_NS::TfTokenVector renderTags) { renderTags_ = std::move(renderTags); }
    bool isConverged() const { return pass_->IsConverged(); }
    const PXR_NS::HdRenderPassAovBindingVector& bindings() const { return bindings_; }

    void Sync(PXR_NS::HdSceneDelegate* delegate, PXR_NS::HdTaskContext* context,
              PXR_NS::HdDirtyBits* dirtyBits) override;
    void Prepare(PXR_NS::HdTaskContext* context, PXR_NS::HdRenderIndex* index) override;
    void Execute(PXR_NS::HdTaskContext* context) override;
    /// Decides which prims are synced at all.
    const PXR_NS::TfTokenVector& GetRenderTags() const override { return renderTags_; }

private:
    PXR_NS::HdRenderPassSharedPtr pass_;
    PXR_NS::HdRenderPassStateSharedPtr state_;
    PXR_NS::HdRenderPassAovBindingVector bindings_;
    PXR_NS::TfTokenVector renderTags_;
    PXR_NS::SdfPath camera_;
    int width_, height_;
    float pixelAspectRatio_ = 1;
};

} // namespace stfrecord
