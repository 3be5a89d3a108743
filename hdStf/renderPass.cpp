// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderPass.h"

#include "hdStf/camera.h"
#include "hdStf/conversions.h"
#include "hdStf/renderBuffer.h"
#include "hdStf/renderDelegate.h"
#include "hdStf/rprim.h"
#include "hdStf/tokens.h"

#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/renderPassState.h"
#include "pxr/imaging/hd/rprimCollection.h"
#include "pxr/imaging/hd/tokens.h"

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

bool _Collects(HdRprimCollection const& collection, SdfPath const& id) {
    const auto isUnder = [&id](SdfPath const& root) { return id.HasPrefix(root); };
    SdfPathVector const& roots = collection.GetRootPaths();
    SdfPathVector const& excluded = collection.GetExcludePaths();
    return std::any_of(roots.begin(), roots.end(), isUnder) && std::none_of(excluded.begin(), excluded.end(), isUnder);
}

} // namespace

HdStfRenderPass::HdStfRenderPass(HdRenderIndex* index, HdRprimCollection const& collection,
                                 HdStfRenderDelegate& delegate, HdStfRenderParam& param, HdStfRenderJob& job)
    : HdRenderPass(index, collection), _delegate(delegate), _param(param), _job(job) {}

HdStfRenderPass::~HdStfRenderPass() {
    _job.SetAovBindings({});
}

bool HdStfRenderPass::IsConverged() const {
    return _job.IsConverged();
}

void HdStfRenderPass::_Sync() {
    _param.FollowShutter(*GetRenderIndex());
}

void HdStfRenderPass::_Execute(HdRenderPassStateSharedPtr const& renderPassState, TfTokenVector const& renderTags) {
    _param.PullMarked(*GetRenderIndex());
    bool restart = _UpdateDrawnPrims(renderTags);
    restart |= _UpdateSettings();
    // Buffers first: the scene's version also tells that one was resized or replaced.
    restart |= _UpdateBindings(renderPassState->GetAovBindings());
    restart |= _UpdateCamera(*renderPassState);
    const int sceneVersion = _param.GetSceneVersion();
    if (_sceneVersion != sceneVersion) {
        _sceneVersion = sceneVersion;
        restart = true;
    }
    if (restart) {
        _job.StartRender();
    }
}

bool HdStfRenderPass::_UpdateDrawnPrims(TfTokenVector const& renderTags) {
    HdRenderIndex* index = GetRenderIndex();
    const unsigned int version = index->GetChangeTracker().GetRenderTagVersion();
    // A new or changed prim passes the gate, and comes with a tag of its own.
    if (!_drawnSetIsStale && version == _renderTagVersion && renderTags == _renderTags &&
        _sceneVersion == _param.GetSceneVersion()) {
        return false;
    }
    _drawnSetIsStale = false;
    _renderTagVersion = version;
    _renderTags = renderTags;
    bool changed = false;
    for (SdfPath const& id : index->GetRprimIds()) {
        auto const* rprim = dynamic_cast<HdStfRprim const*>(index->GetRprim(id));
        if (!rprim) {
            continue;
        }
        const TfToken tag = index->GetRenderTag(id);
        // As in Hydra's own lists: no tags at all choose everything. Blender's task has none.
        const bool tagged =
            renderTags.empty() || std::find(renderTags.begin(), renderTags.end(), tag) != renderTags.end();
        // GetRprim is const because tasks may not edit prims; which of them this pass draws is the pass's own matter.
        changed |= const_cast<HdStfRprim*>(rprim)->SetDrawn(tagged && _Collects(GetRprimCollection(), id), _param);
    }
    return changed;
}

bool HdStfRenderPass::_UpdateSettings() {
    const unsigned int version = _delegate.GetRenderSettingsVersion();
    if (version == _settingsVersion) {
        return false;
    }
    _settingsVersion = version;
    _param.AcquireSceneForEdit().setMetersPerUnit(_delegate.GetMetersPerUnit());
    _job.SetSettings(_delegate.GetStfSettings(),
                     _delegate.GetRenderSetting<bool>(HdStfRenderSettingsTokens->denoise, false));
    // Hosts that write frames say so (usdrecord, stfrecord): nobody looks on.
    _job.SetInteractive(_delegate.GetRenderSetting<bool>(TfToken("enableInteractive"), true));
    return true;
}

bool HdStfRenderPass::_UpdateBindings(HdRenderPassAovBindingVector const& bindings) {
    if (bindings == _boundBindings && _sceneVersion == _param.GetSceneVersion()) {
        return false;
    }
    HdRenderPassAovBindingVector resolved = bindings;
    for (HdRenderPassAovBinding& binding : resolved) {
        if (!binding.renderBuffer) {
            binding.renderBuffer = static_cast<HdRenderBuffer*>(
                GetRenderIndex()->GetBprim(HdPrimTypeTokens->renderBuffer, binding.renderBufferId));
        }
    }
    _boundBindings = bindings;
    _bindings = resolved;
    _job.SetAovBindings(_bindings);
    return true;
}

bool HdStfRenderPass::_UpdateCamera(HdRenderPassState const& state) {
    const GfMatrix4d view = state.GetWorldToViewMatrix();
    const GfMatrix4d projection = state.GetProjectionMatrix();
    HdStfWindow window = _GetWindow(state);
    const stf::FrameWindow frame = _GetFrame(window);
    // Hosts may set the matrices without a camera.
    auto const* camera = dynamic_cast<HdStfCamera const*>(state.GetCamera());
    const stf::CameraOptics optics = camera ? camera->GetOptics() : stf::CameraOptics();
    if (view == _view && projection == _projection && optics == _optics && window == _window && frame == _frame) {
        return false;
    }
    _optics = optics;
    _frame = frame;
    _view = view;
    _projection = projection;
    _window = window;
    _job.SetCamera(HdStfToMatrix4(view), HdStfToMatrix4(projection), optics, window, frame);
    return true;
}

// Which part of the projection's frame the window shows. By itself all of it; with the setting `dataWindowNDC` the
// buffers hold that part of the frame, or more than it, and the viewport or framing says how large the frame is.
stf::FrameWindow HdStfRenderPass::_GetFrame(HdStfWindow& window) const {
    stf::FrameWindow frame = {window.width, window.height, 0, 0, window.width, window.height};
    const GfVec4f data = _delegate.GetDataWindowNDC();
    if (data == GfVec4f(0, 0, 1, 1)) {
        return frame;
    }
    const HdStfWindow part = HdStfDataWindow(data, window.width, window.height);
    frame.x = part.x;
    frame.y = part.y;
    frame.width = part.width;
    frame.height = part.height;
    window = {0, 0, part.width, part.height};
    return frame;
}

HdStfWindow HdStfRenderPass::_GetWindow(HdRenderPassState const& state) const {
#if HDSTF_HAS_FRAMING
    CameraUtilFraming const& framing = state.GetFraming();
    if (framing.IsValid()) {
        // The data window counts rows from the top, buffers from the bottom.
        GfRect2i const& data = framing.dataWindow;
        int height = data.GetMaxY() + 1;
        for (HdRenderPassAovBinding const& binding : _bindings) {
            if (binding.renderBuffer) {
                height = static_cast<int>(binding.renderBuffer->GetHeight());
                break;
            }
        }
        return {data.GetMinX(), height - 1 - data.GetMaxY(), data.GetWidth(), data.GetHeight()};
    }
#endif
    const GfVec4f viewport = state.GetViewport();
    HdStfWindow window = {static_cast<int>(viewport[0]), static_cast<int>(viewport[1]), static_cast<int>(viewport[2]),
                          static_cast<int>(viewport[3])};
    // Hosts that give their window's viewport allocate buffers of its size: the corner is then the window's affair.
    for (HdRenderPassAovBinding const& binding : _bindings) {
        if (binding.renderBuffer && (window.x + window.width > static_cast<int>(binding.renderBuffer->GetWidth()) ||
                                     window.y + window.height > static_cast<int>(binding.renderBuffer->GetHeight()))) {
            window.x = window.y = 0;
            break;
        }
    }
    return window;
}

PXR_NAMESPACE_CLOSE_SCOPE
