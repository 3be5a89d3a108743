// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderParam.h"

#include "hdStf/hydraCompat.h"

#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/rprim.h"
#include "pxr/imaging/hd/sceneDelegate.h"

#if HDSTF_HAS_PRIM_ORIGINS
#include "pxr/imaging/hd/dirtyBitsTranslator.h"
#include "pxr/imaging/hd/sceneIndex.h"
#include "pxr/imaging/hd/sceneIndexObserver.h"
#endif

#include <algorithm>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

stf::Scene& HdStfRenderParam::AcquireSceneForEdit() {
    std::lock_guard<std::mutex> lock(_gate);
    _job.StopRender();
    ++_sceneVersion;
    return _scene;
}

#if HDSTF_HAS_DIRTYING_IN_SYNC

void HdStfRenderParam::MarkAllDirty(HdRenderIndex& index, HdDirtyBits bits) {
    std::lock_guard<std::mutex> lock(_gate);
    index.GetChangeTracker().MarkAllRprimsDirty(bits);
#if HDSTF_HAS_PRIM_ORIGINS
    // That reaches the prims of scene delegates alone. For those of scene indices, whoever brings them to the render
    // index is told as if they had changed; it is all of them, so that one observer is enough.
    HdSceneIndexBaseRefPtr const scene = index.GetTerminalSceneIndex();
    HdSceneIndexObserver* observer = nullptr;
    HdSceneIndexObserver::DirtiedPrimEntries entries;
    for (SdfPath const& id : scene ? index.GetRprimIds() : SdfPathVector()) {
        if (auto* const own = dynamic_cast<HdSceneIndexObserver*>(index.GetSceneDelegateForRprim(id))) {
            observer = own;
            HdDataSourceLocatorSet locators;
            HdDirtyBitsTranslator::RprimDirtyBitsToLocatorSet(scene->GetPrim(id).primType, bits, &locators);
            entries.push_back({id, locators});
        }
    }
    if (observer) {
        observer->PrimsDirtied(*scene, entries);
    }
#endif
}

void HdStfRenderParam::PullMarked(HdRenderIndex& /*index*/) {}

#else

void HdStfRenderParam::MarkAllDirty(HdRenderIndex& /*index*/, HdDirtyBits bits) {
    std::lock_guard<std::mutex> lock(_gate);
    _markedBits |= bits;
}

void HdStfRenderParam::PullMarked(HdRenderIndex& index) {
    HdDirtyBits marked = HdChangeTracker::Clean;
    {
        std::lock_guard<std::mutex> lock(_gate);
        std::swap(marked, _markedBits);
    }
    if (marked == HdChangeTracker::Clean) {
        return;
    }
    for (SdfPath const& id : index.GetRprimIds()) {
        HdDirtyBits bits = marked;
        // GetRprim is const because tasks may not edit prims; here it is the delegate that brings its own up to date.
        const_cast<HdRprim*>(index.GetRprim(id))->Sync(index.GetSceneDelegateForRprim(id), this, &bits, TfToken());
    }
}

#endif

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

void HdStfRenderParam::FollowShutter(HdRenderIndex& index) {
    const stf::Shutter shutter = GetShutter();
    if (!(shutter == _followedShutter)) {
        _followedShutter = shutter;
        MarkAllDirty(index, HdChangeTracker::DirtyTransform);
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
