// SPDX-License-Identifier: Apache-2.0
#include "hdStf/renderDelegate.h"

#include "hdStf/basisCurves.h"
#include "hdStf/camera.h"
#include "hdStf/hostInterface.h"
#include "hdStf/instancer.h"
#include "hdStf/light.h"
#include "hdStf/material.h"
#include "hdStf/mesh.h"
#include "hdStf/points.h"
#include "hdStf/renderBuffer.h"
#include "hdStf/renderPass.h"
#include "hdStf/renderStats.h"
#include "hdStf/settings.h"
#include "hdStf/shaderNode.h"
#include "hdStf/tokens.h"
#include "stfLib/render/denoiser.h"

#include "pxr/base/gf/vec3f.h"
#include "pxr/base/gf/vec4f.h"
#include "pxr/imaging/hd/extComputation.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Null where the type is none that is drawn.
template<class... Arguments>
HdRprim* _CreateRprim(TfToken const& typeId, Arguments const&... arguments) {
    if (typeId == HdPrimTypeTokens->mesh) {
        return new HdStfMesh(arguments...);
    }
    if (typeId == HdPrimTypeTokens->basisCurves) {
        return new HdStfBasisCurves(arguments...);
    }
    if (typeId == HdPrimTypeTokens->points) {
        return new HdStfPoints(arguments...);
    }
    return nullptr;
}

} // namespace

HdStfRenderDelegate::HdStfRenderDelegate()
    : HdRenderDelegate(), _job(_scene, _messages), _renderParam(_scene, _job, _messages) {
    _Initialize();
}

HdStfRenderDelegate::HdStfRenderDelegate(HdRenderSettingsMap const& settingsMap)
    : HdRenderDelegate(settingsMap), _job(_scene, _messages), _renderParam(_scene, _job, _messages) {
    _Initialize();
}

void HdStfRenderDelegate::_Initialize() {
    _resourceRegistry = std::make_shared<HdResourceRegistry>();
    _settingDescriptors = HdStfMakeSettingDescriptors();
    // Settings given at creation: ours in our types, those that cannot be read replaced by the default.
    for (HdRenderSettingDescriptor const& descriptor : _settingDescriptors) {
        const auto it = _settingsMap.find(descriptor.key);
        if (it != _settingsMap.end()) {
            const VtValue value = HdStfNormalizeSetting(_settingDescriptors, descriptor.key, it->second);
            it->second = value.IsEmpty() ? descriptor.defaultValue : value;
        }
    }
    _PopulateDefaultSettings(_settingDescriptors);
    HdStfAnnounceShaderNode();
    HdStfAnnounceDelegate(this);
}

HdStfRenderDelegate::~HdStfRenderDelegate() {
    HdStfRetireDelegate(this);
    _job.StopRender();
}

TfTokenVector const& HdStfRenderDelegate::GetSupportedRprimTypes() const {
    static const TfTokenVector types = {HdPrimTypeTokens->mesh, HdPrimTypeTokens->basisCurves,
                                        HdPrimTypeTokens->points};
    return types;
}

TfTokenVector const& HdStfRenderDelegate::GetSupportedSprimTypes() const {
    static const TfTokenVector types = [] {
        TfTokenVector all = {HdPrimTypeTokens->camera, HdPrimTypeTokens->material, HdPrimTypeTokens->extComputation};
        TfTokenVector const& lights = HdStfLight::GetTypes();
        all.insert(all.end(), lights.begin(), lights.end());
        return all;
    }();
    return types;
}

TfTokenVector const& HdStfRenderDelegate::GetSupportedBprimTypes() const {
    static const TfTokenVector types = {HdPrimTypeTokens->renderBuffer};
    return types;
}

HdRenderParam* HdStfRenderDelegate::GetRenderParam() const {
    return const_cast<HdStfRenderParam*>(&_renderParam);
}

HdResourceRegistrySharedPtr HdStfRenderDelegate::GetResourceRegistry() const {
    return _resourceRegistry;
}

HdRenderSettingDescriptorList HdStfRenderDelegate::GetRenderSettingDescriptors() const {
    return HdStfPanelDescriptors(_settingDescriptors);
}

void HdStfRenderDelegate::SetRenderSetting(TfToken const& key, VtValue const& value) {
    const VtValue typed = HdStfNormalizeSetting(_settingDescriptors, key, value);
    if (!typed.IsEmpty() && typed != GetRenderSetting(key)) {
        HdRenderDelegate::SetRenderSetting(key, typed);
    }
}

VtDictionary HdStfRenderDelegate::GetRenderStats() const {
    return HdStfMakeRenderStats(_job.GetProgress(), _messages);
}

bool HdStfRenderDelegate::Pause() {
    _job.Pause();
    return true;
}

bool HdStfRenderDelegate::Resume() {
    _job.Resume();
    return true;
}

#if HDSTF_HAS_IS_STOPPED
bool HdStfRenderDelegate::Stop(bool /*blocking: cancelling takes milliseconds*/) {
#else
bool HdStfRenderDelegate::Stop() {
#endif
    _job.Stop();
    return true;
}

bool HdStfRenderDelegate::Restart() {
    _job.Restart();
    return true;
}

HdRenderPassSharedPtr HdStfRenderDelegate::CreateRenderPass(HdRenderIndex* index, HdRprimCollection const& collection) {
    return std::make_shared<HdStfRenderPass>(index, collection, *this, _renderParam, _job);
}

#if HDSTF_HAS_INSTANCER_ID_ARGUMENT
HdInstancer* HdStfRenderDelegate::CreateInstancer(HdSceneDelegate* delegate, SdfPath const& id,
                                                  SdfPath const& instancerId) {
    return new HdStfInstancer(delegate, id, instancerId);
}

HdRprim* HdStfRenderDelegate::CreateRprim(TfToken const& typeId, SdfPath const& rprimId, SdfPath const& instancerId) {
    if (HdRprim* rprim = _CreateRprim(typeId, rprimId, instancerId)) {
        return rprim;
    }
#else
HdInstancer* HdStfRenderDelegate::CreateInstancer(HdSceneDelegate* delegate, SdfPath const& id) {
    return new HdStfInstancer(delegate, id);
}

HdRprim* HdStfRenderDelegate::CreateRprim(TfToken const& typeId, SdfPath const& rprimId) {
    if (HdRprim* rprim = _CreateRprim(typeId, rprimId)) {
        return rprim;
    }
#endif
    TF_CODING_ERROR("hdStf has no rprim of type %s", typeId.GetText());
    return nullptr;
}

void HdStfRenderDelegate::DestroyInstancer(HdInstancer* instancer) {
    delete instancer;
}

void HdStfRenderDelegate::DestroyRprim(HdRprim* rprim) {
    delete rprim;
}

HdSprim* HdStfRenderDelegate::CreateSprim(TfToken const& typeId, SdfPath const& sprimId) {
    if (typeId == HdPrimTypeTokens->camera) {
        return new HdStfCamera(sprimId);
    }
    if (typeId == HdPrimTypeTokens->material) {
        return new HdStfMaterial(sprimId);
    }
    if (typeId == HdPrimTypeTokens->extComputation) {
        return new HdExtComputation(sprimId);
    }
    if (HdStfLight::IsLightType(typeId)) {
        return new HdStfLight(sprimId, typeId);
    }
    TF_CODING_ERROR("hdStf has no sprim of type %s", typeId.GetText());
    return nullptr;
}

HdSprim* HdStfRenderDelegate::CreateFallbackSprim(TfToken const& typeId) {
    return CreateSprim(typeId, SdfPath::EmptyPath());
}

void HdStfRenderDelegate::DestroySprim(HdSprim* sprim) {
    delete sprim;
}

HdBprim* HdStfRenderDelegate::CreateBprim(TfToken const& typeId, SdfPath const& bprimId) {
    if (typeId == HdPrimTypeTokens->renderBuffer) {
        return new HdStfRenderBuffer(bprimId);
    }
    TF_CODING_ERROR("hdStf has no bprim of type %s", typeId.GetText());
    return nullptr;
}

HdBprim* HdStfRenderDelegate::CreateFallbackBprim(TfToken const& typeId) {
    return CreateBprim(typeId, SdfPath::EmptyPath());
}

void HdStfRenderDelegate::DestroyBprim(HdBprim* bprim) {
    delete bprim;
}

void HdStfRenderDelegate::CommitResources(HdChangeTracker* /*tracker*/) {}

#if HDSTF_HAS_MATERIAL_RENDER_CONTEXTS
TfTokenVector HdStfRenderDelegate::GetMaterialRenderContexts() const {
    return {HdStfMaterialTokens->stf};
}
#else
TfToken HdStfRenderDelegate::GetMaterialNetworkSelector() const {
    return HdStfMaterialTokens->stf;
}
#endif

#if HDSTF_HAS_PARALLEL_SYNC_QUERY
bool HdStfRenderDelegate::IsParallelSyncEnabled(TfToken const& primType) const {
    return primType == HdPrimTypeTokens->extComputation || primType == HdPrimTypeTokens->material;
}
#endif

HdAovDescriptor HdStfRenderDelegate::GetDefaultAovDescriptor(TfToken const& name) const {
    stf::Aov aov;
    if (!stf::aovFromName(name.GetString(), aov)) {
        return HdAovDescriptor();
    }
    if (std::string why; aov == stf::Aov::Denoised && !stf::Denoiser::available(&why)) {
        _messages.Report(stf::Severity::Warning, "AOV \"denoised\": " + why);
        return HdAovDescriptor();
    }
    if (aov == stf::Aov::Depth) {
        return HdAovDescriptor(HdFormatFloat32, false, VtValue(1.0f));
    }
    if (stf::aovIsInteger(aov)) {
        return HdAovDescriptor(HdFormatInt32, false, VtValue(aov == stf::Aov::SampleCount ? 0 : -1));
    }
    switch (stf::aovChannels(aov)) {
    case 1:
        return HdAovDescriptor(HdFormatFloat32, false, VtValue(0.0f));
    case 3:
        return HdAovDescriptor(HdFormatFloat32Vec3, false, VtValue(GfVec3f(0.0f)));
    default:
        return HdAovDescriptor(HdFormatFloat32Vec4, false, VtValue(GfVec4f(0.0f)));
    }
}

stf::RenderSettings HdStfRenderDelegate::GetStfSettings() const {
    stf::RenderSettings settings;
    settings.samples = GetRenderSetting<int>(HdStfRenderSettingsTokens->samples, settings.samples);
    settings.seed = static_cast<uint64_t>(GetRenderSetting<int>(HdStfRenderSettingsTokens->seed, 0));
    settings.tableSeed = static_cast<uint64_t>(GetRenderSetting<int>(HdStfRenderSettingsTokens->tableSeed, 0));
    settings.threads = GetRenderSetting<int>(HdStfRenderSettingsTokens->threads, settings.threads);
    settings.maxDepth = GetRenderSetting<int>(HdStfRenderSettingsTokens->maxDepth, settings.maxDepth);
    settings.indirectClamp = GetRenderSetting<float>(HdStfRenderSettingsTokens->indirectClamp, settings.indirectClamp);
    settings.regularize = GetRenderSetting<bool>(HdStfRenderSettingsTokens->regularize, settings.regularize);
    settings.quality = GetRenderSetting<float>(HdStfRenderSettingsTokens->quality, settings.quality);
    settings.errorTarget = GetRenderSetting<float>(HdStfRenderSettingsTokens->errorTarget, settings.errorTarget);
    settings.integrator = GetRenderSetting<std::string>(HdStfRenderSettingsTokens->integrator, settings.integrator);
    settings.transport = GetRenderSetting<std::string>(HdStfRenderSettingsTokens->transport, settings.transport);
    settings.pixelFilter = GetRenderSetting<std::string>(HdStfRenderSettingsTokens->pixelFilter, settings.pixelFilter);
    settings.pixelFilterWidth =
        GetRenderSetting<float>(HdStfRenderSettingsTokens->pixelFilterWidth, settings.pixelFilterWidth);
    settings.depthOfField = GetRenderSetting<bool>(HdStfRenderSettingsTokens->depthOfField, settings.depthOfField);
    settings.irradianceCache =
        GetRenderSetting<bool>(HdStfRenderSettingsTokens->irradianceCache, settings.irradianceCache);
    settings.motionBlur = GetRenderSetting<bool>(HdStfRenderSettingsTokens->motionBlur, settings.motionBlur);
    settings.exact = stf::Exactness::parse(GetRenderSetting<std::string>(HdStfRenderSettingsTokens->exact, ""));
    return settings;
}

GfVec4f HdStfRenderDelegate::GetDataWindowNDC() const {
    return GetRenderSetting<GfVec4f>(HdStfRenderSettingsTokens->dataWindowNDC, GfVec4f(0, 0, 1, 1));
}

double HdStfRenderDelegate::GetMetersPerUnit() const {
    return GetRenderSetting<double>(HdStfRenderSettingsTokens->stageMetersPerUnit, 0.01);
}

PXR_NAMESPACE_CLOSE_SCOPE
