// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/messages.h"
#include "hdStf/renderJob.h"
#include "stfLib/base/motion.h"
#include "stfLib/render/scene.h"

#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/renderDelegate.h"
#include "pxr/pxr.h"
#include "pxr/usd/sdf/path.h"

#include <atomic>
#include <map>
#include <mutex>

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfRenderParam
///
/// What prims reach during Sync and Finalize: the scene behind one gate, and the message list.
///
/// Threading: Hydra syncs rprims in parallel, so every method may be called from several threads at once.
class HdStfRenderParam final : public HdRenderParam {
public:
    HdStfRenderParam(stf::Scene& scene, HdStfRenderJob& job, HdStfMessages& messages)
        : _scene(scene), _job(job), _messages(messages) {}

    /// The single gate for all mutation of the scene and of render buffers: stops rendering (a running stage of stfLib
    /// is cancelled) and waits for it, then raises the scene's version so that the next execute starts anew.
    stf::Scene& AcquireSceneForEdit();

    /// The scene's version; grows with each pass through the gate.
    int GetSceneVersion() const { return _sceneVersion.load(); }

    /// When a camera's shutter is open; cameras sync before prims.
    void SetShutter(SdfPath const& camera, stf::Shutter const& shutter);
    /// From the first opening to the last closing of all cameras; does not blur where none does, so that it is not
    /// worth asking how prims move.
    stf::Shutter GetShutter() const;
    /// Between cameras' sync and that of the prims: where the shutter is another than at the last call, prims have to
    /// tell how they move anew. Cameras themselves cannot see that: some go without being there to sync.
    void FollowShutter(HdRenderIndex& index);

    /// Has all rprims pull something again: with this sync, or, where Hydra does not allow that, with `PullMarked`.
    void MarkAllDirty(HdRenderIndex& index, HdDirtyBits bits);
    /// After all have synced: rprims pull what was marked and is not pulled yet. Hydra's execute thread.
    void PullMarked(HdRenderIndex& index);

    /// A render buffer goes away: nothing may be written to it any more.
    void ForgetBuffer(HdStfRenderBuffer const* buffer);

    HdStfMessages& GetMessages() const { return _messages; }

private:
    stf::Scene& _scene;
    HdStfRenderJob& _job;
    HdStfMessages& _messages;
    std::mutex _gate;
    HdDirtyBits _markedBits = HdChangeTracker::Clean; // behind the gate
    std::atomic<int> _sceneVersion{1};
    mutable std::mutex _shutterMutex;
    std::map<SdfPath, stf::Shutter> _shutters; // those that blur
    stf::Shutter _followedShutter;             // Hydra's execute thread only
};

PXR_NAMESPACE_CLOSE_SCOPE
