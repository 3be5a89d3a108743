// SPDX-License-Identifier: Apache-2.0
#include "hdStf/light.h"

#include "hdStf/conversions.h"
#include "hdStf/hydraCompat.h"
#include "hdStf/renderParam.h"

#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/usd/sdf/assetPath.h"
#include "pxr/usd/usdLux/blackbody.h"

#include <algorithm>
#include <cmath>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

VtValue _GetParam(HdSceneDelegate* sceneDelegate, SdfPath const& id, TfToken const& name) {
#if HDSTF_LIGHT_PARAMS_ARE_ATTRIBUTES
    // This Hydra reads the attribute of just that name; scenes authored for later versions have `inputs:` ones, and
    // `intensity` would then be the old schema's fallback.
    const VtValue value = sceneDelegate->GetLightParamValue(id, TfToken("inputs:" + name.GetString()));
    if (!value.IsEmpty()) {
        return value;
    }
#endif
    return sceneDelegate->GetLightParamValue(id, name);
}

template<class T>
T _GetParam(HdSceneDelegate* sceneDelegate, SdfPath const& id, TfToken const& name, T const& fallback) {
    const VtValue value = VtValue::Cast<T>(_GetParam(sceneDelegate, id, name));
    return value.IsEmpty() ? fallback : value.template UncheckedGet<T>();
}

GfMatrix4d _GetTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id) {
#if HDSTF_LIGHT_TRANSFORM_IS_PARAM
    return sceneDelegate->GetLightParamValue(id, HdTokens->transform).GetWithDefault(GfMatrix4d(1.0));
#else
    return sceneDelegate->GetTransform(id);
#endif
}

} // namespace

TfTokenVector const& HdStfLight::GetTypes() {
    static const TfTokenVector types = {HdPrimTypeTokens->distantLight, HdPrimTypeTokens->domeLight,
                                        HdPrimTypeTokens->diskLight,    HdPrimTypeTokens->rectLight,
                                        HdPrimTypeTokens->sphereLight,  HdPrimTypeTokens->cylinderLight};
    return types;
}

bool HdStfLight::IsLightType(TfToken const& type) {
    TfTokenVector const& types = GetTypes();
    return std::find(types.begin(), types.end(), type) != types.end();
}

void HdStfLight::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
    auto* param = static_cast<HdStfRenderParam*>(renderParam);
    const HdDirtyBits bits = *dirtyBits;
    *dirtyBits = Clean;
    if (_type != HdPrimTypeTokens->distantLight && _type != HdPrimTypeTokens->domeLight) {
        param->GetMessages().Report(stf::Severity::Error, "lights of type " + _type.GetString() +
                                                              " are not supported and are ignored (" +
                                                              GetId().GetString() + ")");
        return;
    }

    stf::Light light = _light;
    light.type = _type == HdPrimTypeTokens->domeLight ? stf::Light::Type::Dome : stf::Light::Type::Distant;
    if (bits & DirtyTransform) {
        light.lightToWorld = HdStfToTransform(_GetTransform(sceneDelegate, GetId()));
    }
    if (bits & DirtyParams) {
        _ReadParams(sceneDelegate, light);
    }
    if (_inScene && light == _light) {
        return;
    }
    _light = light;
    _inScene = true;
    param->AcquireSceneForEdit().setLight(GetId().GetString(), _light);
}

void HdStfLight::_ReadParams(HdSceneDelegate* sceneDelegate, stf::Light& light) const {
    SdfPath const& id = GetId();
    const float intensity = _GetParam(sceneDelegate, id, HdLightTokens->intensity, 1.0f);
    const float exposure = _GetParam(sceneDelegate, id, HdLightTokens->exposure, 0.0f);
    GfVec3f color = _GetParam(sceneDelegate, id, HdLightTokens->color, GfVec3f(1.0f));
    if (_GetParam(sceneDelegate, id, HdLightTokens->enableColorTemperature, false)) {
        const float kelvin = _GetParam(sceneDelegate, id, HdLightTokens->colorTemperature, 6500.0f);
        color = GfCompMult(color, UsdLuxBlackbodyTemperatureAsRgb(kelvin));
    }
    light.emission = HdStfToVec3f(color * (intensity * std::exp2(exposure)));
    light.normalize = _GetParam(sceneDelegate, id, HdLightTokens->normalize, false);
    light.angle =
        light.type == stf::Light::Type::Distant ? _GetParam(sceneDelegate, id, HdLightTokens->angle, 0.53f) : 0.0f;
    light.textureFile.clear();
    if (light.type == stf::Light::Type::Dome) {
        const SdfAssetPath file = _GetParam(sceneDelegate, id, HdLightTokens->textureFile, SdfAssetPath());
        light.textureFile = file.GetResolvedPath().empty() ? file.GetAssetPath() : file.GetResolvedPath();
    }
    light.visible = sceneDelegate->GetVisible(id);
}

void HdStfLight::Finalize(HdRenderParam* renderParam) {
    if (_inScene) {
        static_cast<HdStfRenderParam*>(renderParam)->AcquireSceneForEdit().removeLight(GetId().GetString());
        _inScene = false;
    }
    HdLight::Finalize(renderParam);
}

PXR_NAMESPACE_CLOSE_SCOPE
