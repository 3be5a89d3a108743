// SPDX-License-Identifier: Apache-2.0
#include "hdStf/light.h"

#include "hdStf/conversions.h"
#include "hdStf/hydraCompat.h"
#include "hdStf/renderParam.h"

#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/renderIndex.h"
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

stf::Light::Type _GetType(TfToken const& type) {
    using Type = stf::Light::Type;
    return type == HdPrimTypeTokens->domeLight       ? Type::Dome
           : type == HdPrimTypeTokens->diskLight     ? Type::Disk
           : type == HdPrimTypeTokens->rectLight     ? Type::Rect
           : type == HdPrimTypeTokens->sphereLight   ? Type::Sphere
           : type == HdPrimTypeTokens->cylinderLight ? Type::Cylinder
                                                     : Type::Distant;
}

std::string _GetPath(SdfAssetPath const& file) {
    return file.GetResolvedPath().empty() ? file.GetAssetPath() : file.GetResolvedPath();
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
    stf::Light light = _light;
    light.type = _GetType(_type);
    if (bits & DirtyTransform) {
        light.lightToWorld = HdStfToTransform(_GetTransform(sceneDelegate, GetId()));
    }
    if (bits & DirtyParams) {
        _ReadParams(sceneDelegate, light);
    }
    if (bits & (DirtyParams | DirtyCollection)) {
        // A collection that holds everything has no id.
        const auto link = [&](TfToken const& name) {
            return sceneDelegate->GetLightParamValue(GetId(), name).GetWithDefault(TfToken()).GetString();
        };
        light.lightLink = link(HdTokens->lightLink);
        light.shadowLink = link(HdTokens->shadowLink);
        const auto links = [](stf::Light const& l) { return !l.lightLink.empty() || !l.shadowLink.empty(); };
        if (links(light) || links(_light)) {
            // UsdImaging tells a light that its collections have changed, but not the prims in them.
            param->MarkAllDirty(sceneDelegate->GetRenderIndex(), HdChangeTracker::DirtyCategories);
        }
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
    if (light.type == stf::Light::Type::Dome || light.type == stf::Light::Type::Rect) {
        light.textureFile = _GetPath(_GetParam(sceneDelegate, id, HdLightTokens->textureFile, SdfAssetPath()));
    }
    light.shadows = _GetParam(sceneDelegate, id, HdLightTokens->shadowEnable, true);
    // What UsdLux falls back to where the attribute is not there.
    light.radius = _GetParam(sceneDelegate, id, HdLightTokens->radius, 0.5f);
    light.width = _GetParam(sceneDelegate, id, HdLightTokens->width, 1.0f);
    light.height = _GetParam(sceneDelegate, id, HdLightTokens->height, 1.0f);
    light.length = _GetParam(sceneDelegate, id, HdLightTokens->length, 1.0f);
    stf::LightShaping& shaping = light.shaping;
    shaping.focus = _GetParam(sceneDelegate, id, HdLightTokens->shapingFocus, 0.0f);
    shaping.focusTint = HdStfToVec3f(_GetParam(sceneDelegate, id, HdLightTokens->shapingFocusTint, GfVec3f(0.0f)));
    shaping.coneAngle = _GetParam(sceneDelegate, id, HdLightTokens->shapingConeAngle, 180.0f);
    shaping.coneSoftness = _GetParam(sceneDelegate, id, HdLightTokens->shapingConeSoftness, 0.0f);
    shaping.iesFile = _GetPath(_GetParam(sceneDelegate, id, HdLightTokens->shapingIesFile, SdfAssetPath()));
    shaping.iesAngleScale = _GetParam(sceneDelegate, id, HdLightTokens->shapingIesAngleScale, 0.0f);
    shaping.iesNormalize = _GetParam(sceneDelegate, id, HdLightTokens->shapingIesNormalize, false);
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
