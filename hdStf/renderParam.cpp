// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderParam.h"

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

stf::Scene& HdStfRenderParam::AcquireSceneForEdit() {
    std::lock_guard<std::mutex> lock(_gate);
    _job.StopRender();
    ++_sceneVersion;
    return _scene;
}

void HdStfRenderParam::MarkAllDirty(HdChangeTracker& tracker, HdDirtyBits bits) {
    std::lock_guard<std::mutex> lock(_gate);
    tracker.MarkAllRprimsDirty(bits);
}

void HdStfRenderParam::ForgetBuffer(HdStfRenderBuffer const* buffer) {
    std::lock_guard<std::mutex> lock(_gate);
    _job.ForgetBuffer(buffer);
    ++_sceneVersion;
}

void HdStfRenderParam::SetShutter(SdfPath const& camera, stf::Shutter const& shutter) {
    std::lock_guard<std::mutex> lock(_shutterMutex);
    if (shutter.blurs()) {
        _shutters[camera] = shutter;
    } else {
        _shutters.erase(camera);
    }
}

stf::Shutter HdStfRenderParam::GetShutter() const {
    std::lock_guard<std::mutex> lock(_shutterMutex);
    if (_shutters.empty()) {
        return {};
    }
    stf::Shutter all = _shutters.begin()->second;
    for (auto const& [id, shutter] : _shutters) {
        all.open = std::min(all.open, shutter.open);
        all.close = std::max(all.close, shutter.close);
    }
    return all;
}

void HdStfRenderParam::FollowShutter(HdChangeTracker& tracker) {
    const stf::Shutter shutter = GetShutter();
    if (!(shutter == _followedShutter)) {
        _followedShutter = shutter;
        MarkAllDirty(tracker, HdChangeTracker::DirtyTransform);
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
