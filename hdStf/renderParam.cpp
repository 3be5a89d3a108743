// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderParam.h"

PXR_NAMESPACE_OPEN_SCOPE

stf::Scene& HdStfRenderParam::AcquireSceneForEdit() {
    std::lock_guard<std::mutex> lock(_gate);
    _job.StopRender();
    ++_sceneVersion;
    return _scene;
}

void HdStfRenderParam::MarkPrimvarsDirty(HdChangeTracker& tracker) {
    std::lock_guard<std::mutex> lock(_gate);
    tracker.MarkAllRprimsDirty(HdChangeTracker::DirtyPrimvar);
}

void HdStfRenderParam::ForgetBuffer(HdStfRenderBuffer const* buffer) {
    std::lock_guard<std::mutex> lock(_gate);
    _job.ForgetBuffer(buffer);
    ++_sceneVersion;
}

PXR_NAMESPACE_CLOSE_SCOPE
