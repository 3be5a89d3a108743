// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"
#include "hdStf/renderJob.h"
#include "hdStf/window.h"

#include "pxr/base/gf/matrix4d.h"
#include "pxr/imaging/hd/aov.h"
#include "pxr/imaging/hd/renderPass.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

class HdStfRenderDelegate;
class HdStfRenderParam;

/// \class HdStfRenderPass
///
/// Hands camera, window, AOV bindings, settings and the set of drawn prims to the render job, and starts it anew only
/// where one of them, or the scene, changed.
///
/// Threading: Hydra's execute thread only.
class HdStfRenderPass final : public HdRenderPass {
public:
    HdStfRenderPass(HdRenderIndex* index, HdRprimCollection const& collection, HdStfRenderDelegate& delegate,
                    HdStfRenderParam& param, HdStfRenderJob& job);
    ~HdStfRenderPass() override;

    /// True where every bound buffer is.
    bool IsConverged() const override;

protected:
    void _Sync() override;
    void _Execute(HdRenderPassStateSharedPtr const& renderPassState, TfTokenVector const& renderTags) override;
    void _MarkCollectionDirty() override { _drawnSetIsStale = true; }

private:
    bool _UpdateDrawnPrims(TfTokenVector const& renderTags);
    bool _UpdateSettings();
    bool _UpdateBindings(HdRenderPassAovBindingVector const& bindings);
    bool _UpdateCamera(HdRenderPassState const& state);
    HdStfWindow _GetWindow(HdRenderPassState const& state) const;
    stf::FrameWindow _GetFrame(HdStfWindow& window) const;

    HdStfRenderDelegate& _delegate;
    HdStfRenderParam& _param;
    HdStfRenderJob& _job;

    HdRenderPassAovBindingVector _boundBindings; // as the host gave them
    HdRenderPassAovBindingVector _bindings;      // with buffers looked up
    GfMatrix4d _view{1.0};
    GfMatrix4d _projection{1.0};
    stf::CameraOptics _optics;
    HdStfWindow _window;
    stf::FrameWindow _frame;
    TfTokenVector _renderTags;
    unsigned int _renderTagVersion = 0;
    unsigned int _settingsVersion = 0;
    int _sceneVersion = 0;
    bool _drawnSetIsStale = true;
};

PXR_NAMESPACE_CLOSE_SCOPE
