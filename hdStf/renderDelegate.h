// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"
#include "hdStf/messages.h"
#include "hdStf/renderJob.h"
#include "hdStf/renderParam.h"
#include "stfLib/render/scene.h"

#include "pxr/imaging/hd/renderDelegate.h"
#include "pxr/imaging/hd/resourceRegistry.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfRenderDelegate
///
/// Translates between Hydra and stfLib. It owns the scene (plain values, written by prims through the edit gate of the
/// render param), the render job (the renderer and its thread) and the messages.
///
/// Threading: Hydra calls it from one thread, except that prims sync in parallel; destruction stops rendering first.
class HdStfRenderDelegate final : public HdRenderDelegate {
public:
    HdStfRenderDelegate();
    explicit HdStfRenderDelegate(HdRenderSettingsMap const& settingsMap);
    ~HdStfRenderDelegate() override;

    TfTokenVector const& GetSupportedRprimTypes() const override;
    TfTokenVector const& GetSupportedSprimTypes() const override;
    TfTokenVector const& GetSupportedBprimTypes() const override;

    HdRenderParam* GetRenderParam() const override;
    HdResourceRegistrySharedPtr GetResourceRegistry() const override;

    HdRenderSettingDescriptorList GetRenderSettingDescriptors() const override;
    /// A setting set to its own value restarts nothing; one that is not known, or of a wrong type, is ignored.
    void SetRenderSetting(TfToken const& key, VtValue const& value) override;
    VtDictionary GetRenderStats() const override;

    bool IsPauseSupported() const override { return true; }
    bool Pause() override;
    bool Resume() override;
    bool IsStopSupported() const override { return true; }
#if HDSTF_HAS_IS_STOPPED
    bool IsPaused() const override {
        return _job.IsPaused();
    }
    bool IsStopped() const override {
        return _job.IsStopped();
    }
    bool Stop(bool blocking = true) override;
#else
    bool Stop() override;
#endif
    bool Restart() override;

    HdRenderPassSharedPtr CreateRenderPass(HdRenderIndex* index, HdRprimCollection const& collection) override;

#if HDSTF_HAS_INSTANCER_ID_ARGUMENT
    HdInstancer* CreateInstancer(HdSceneDelegate* delegate, SdfPath const& id, SdfPath const& instancerId) override;
    HdRprim* CreateRprim(TfToken const& typeId, SdfPath const& rprimId, SdfPath const& instancerId) override;
#else
    HdInstancer* CreateInstancer(HdSceneDelegate* delegate, SdfPath const& id) override;
    HdRprim* CreateRprim(TfToken const& typeId, SdfPath const& rprimId) override;
#endif
    void DestroyInstancer(HdInstancer* instancer) override;
    void DestroyRprim(HdRprim* rprim) override;
    HdSprim* CreateSprim(TfToken const& typeId, SdfPath const& sprimId) override;
    HdSprim* CreateFallbackSprim(TfToken const& typeId) override;
    void DestroySprim(HdSprim* sprim) override;
    HdBprim* CreateBprim(TfToken const& typeId, SdfPath const& bprimId) override;
    HdBprim* CreateFallbackBprim(TfToken const& typeId) override;
    void DestroyBprim(HdBprim* bprim) override;

    void CommitResources(HdChangeTracker* tracker) override;

#if HDSTF_HAS_MATERIAL_RENDER_CONTEXTS
    TfTokenVector GetMaterialRenderContexts() const override;
#else
    TfToken GetMaterialNetworkSelector() const override;
#endif
#if HDSTF_HAS_PARALLEL_SYNC_QUERY
    bool IsParallelSyncEnabled(TfToken const& primType) const override;
#endif

    HdAovDescriptor GetDefaultAovDescriptor(TfToken const& name) const override;

    /// The values of the settings now, as stfLib takes them.
    stf::RenderSettings GetStfSettings() const;
    double GetMetersPerUnit() const;
    /// Which part of the frame the buffers hold: x and y from, x and y to, shares of the frame from its lower left.
    GfVec4f GetDataWindowNDC() const;
    /// What prims have made of the host's scene. To be looked at by tests, from the thread that executes.
    stf::Scene const& GetScene() const {
        return _scene;
    }

private:
    void _Initialize();

    HdRenderSettingDescriptorList _settingDescriptors;
    HdResourceRegistrySharedPtr _resourceRegistry;
    mutable HdStfMessages _messages; // a list of what was said; const queries may have something to say
    stf::Scene _scene;
    HdStfRenderJob _job;
    HdStfRenderParam _renderParam;
};

PXR_NAMESPACE_CLOSE_SCOPE
