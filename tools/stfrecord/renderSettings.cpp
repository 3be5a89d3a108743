// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/renderSettings.h"

#include "pxr/pxr.h"
#include "pxr/usd/usd/editContext.h"
#include "pxr/usd/usdGeom/camera.h"
#include "pxr/usd/usdRender/product.h"
#include "pxr/usd/usdRender/settings.h"
#include "pxr/usd/usdRender/spec.h"
#include "pxr/usd/usdRender/tokens.h"
#include "pxr/usd/usdRender/var.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

using Complain = std::function<void(const std::string&)>;
constexpr int largest = 32768; // pixels

UsdRenderSpec computeSpec(const UsdRenderSettings& settings, UsdTimeCode time) {
#if PXR_VERSION >= 2305
    (void)time; // since then the attributes are uniform
    return UsdRenderComputeSpec(settings, {TfToken("stf")});
#else
    return UsdRenderComputeSpec(settings, time, {"stf:"});
#endif
}

/// Attributes of the namespace stf, of a spec or of a product.
template<class Spec>
const VtDictionary& stfSettings(const Spec& spec) {
#if PXR_VERSION >= 2305
    return spec.namespacedSettings;
#else
    return spec.extraSettings;
#endif
}

/// A var's AOVs; none, with a word, where the renderer can have none.
void readVar(const UsdStagePtr& stage, const UsdRenderSpec::RenderVar& var, std::set<std::string>& layers,
             std::vector<ProductVar>& vars, const Complain& complain) {
    const std::string path = var.renderVarPath.GetString();
    if (!var.sourceType.IsEmpty() && var.sourceType != UsdRenderTokens->raw) {
        complain("render var " + path + ": sources of type " + var.sourceType.GetString() +
                 " are not rendered, it is left out");
        return;
    }
    // The name that Houdini gives layers, else that of the AOV; of two with the same AOV the second has its prim's.
    std::string name = var.sourceName;
    if (const UsdAttribute named =
            stage->GetPrimAtPath(var.renderVarPath).GetAttribute(TfToken("driver:parameters:aov:name"))) {
        named.Get(&name);
    }
    name = name.empty() || layers.count(name) ? var.renderVarPath.GetName() : name;
    layers.insert(name);
    for (const std::string& aov : aovsOf(var.sourceName)) {
        vars.push_back(
            {aov, aov == var.sourceName ? name : name + aov.substr(var.sourceName.size()), var.dataType.GetString()});
    }
}

Product readProduct(const UsdStagePtr& stage, const UsdRenderSpec& spec, const UsdRenderSpec::Product& given,
                    const Complain& complain) {
    Product product;
    product.file = given.name.GetString();
    product.camera = given.cameraPath;
    product.width = std::clamp(given.resolution[0], 1, largest);
    product.height = std::clamp(given.resolution[1], 1, largest);
    product.pixelAspectRatio =
        given.pixelAspectRatio > 0 && std::isfinite(given.pixelAspectRatio) ? given.pixelAspectRatio : 1.0f;
    if (given.apertureSize[0] > 0 && given.apertureSize[1] > 0) {
        product.aperture = given.apertureSize;
    }
    const GfVec2f low = given.dataWindowNDC.GetMin(), high = given.dataWindowNDC.GetMax();
    if (low != GfVec2f(0) || high != GfVec2f(1)) {
        product.dataWindow = {{low[0], low[1], high[0], high[1]}};
    }
    product.settings = stfSettings(spec);
    for (const auto& [key, value] : stfSettings(given)) {
        product.settings[key] = value;
    }
    bool instantaneous = false;
#if PXR_VERSION >= 2211
    instantaneous = given.disableMotionBlur;
#else
    instantaneous = given.instantaneousShutter;
#endif
    if (instantaneous) {
        product.settings["stf:motionBlur"] = VtValue(false);
    }
    std::set<std::string> layers;
    for (const size_t index : given.renderVarIndices) {
        readVar(stage, spec.renderVars[index], layers, product.vars, complain);
    }
    return product;
}

} // namespace

SdfPath findRenderSettings(const UsdStagePtr& stage, const std::string& path, std::string& problem) {
    std::string named = path;
    if (named.empty()) {
        stage->GetMetadata(UsdRenderTokens->renderSettingsPrimPath, &named);
    }
    if (named.empty()) {
        return SdfPath();
    }
    const SdfPath wanted = SdfPath::IsValidPathString(named) ? SdfPath(named) : SdfPath();
    const UsdPrim prim = wanted.IsAbsolutePath() ? stage->GetPrimAtPath(wanted) : UsdPrim();
    if (!prim || !prim.IsA<UsdRenderSettings>()) {
        problem = "there is no RenderSettings prim " + named;
        return SdfPath();
    }
    return wanted;
}

RenderSettings readRenderSettings(const UsdStagePtr& stage, const SdfPath& path, UsdTimeCode time,
                                  const Complain& complain) {
    const UsdRenderSettings prim(stage->GetPrimAtPath(path));
    RenderSettings result;
    const UsdRenderSpec spec = computeSpec(prim, time);
    for (const TfToken& purpose : spec.includedPurposes) {
        result.purposes.push_back(purpose.GetString());
    }
    if (prim.GetMaterialBindingPurposesAttr().HasAuthoredValue()) {
        complain(path.GetString() + ": materialBindingPurposes are not read; materials are bound as for a full render");
    }
    SdfPathVector targets;
    prim.GetProductsRel().GetForwardedTargets(&targets);
    // The spec leaves out what is no product, and, with an error of its own, what has no camera.
    size_t next = 0;
    for (const SdfPath& target : targets) {
        const UsdRenderProduct productPrim(stage->GetPrimAtPath(target));
        if (!productPrim) {
            complain(path.GetString() + ": " + target.GetString() + " is no RenderProduct, it is left out");
            continue;
        }
        SdfPathVector cameras;
        productPrim.GetCameraRel().GetForwardedTargets(&cameras);
        if (cameras.empty()) {
            prim.GetCameraRel().GetForwardedTargets(&cameras);
        }
        if (cameras.empty() || !UsdGeomCamera(stage->GetPrimAtPath(cameras[0])) || next >= spec.products.size()) {
            continue;
        }
        const UsdRenderSpec::Product& given = spec.products[next++];
        if (given.type != UsdRenderTokens->raster) {
            complain(target.GetString() + ": products of type " + given.type.GetString() +
                     " are not rendered, it is left out");
            continue;
        }
        Product product = readProduct(stage, spec, given, complain);
        product.name = target.GetName();
        if (product.vars.empty()) {
            complain(target.GetString() + ": it has no render var that can be rendered, it is left out");
            continue;
        }
        result.products.push_back(std::move(product));
    }
    return result;
}

void setAperture(const UsdStagePtr& stage, const Product& product) {
    if (!product.aperture) {
        return;
    }
    const UsdGeomCamera camera(stage->GetPrimAtPath(product.camera));
    UsdEditContext context(stage, stage->GetSessionLayer());
    camera.GetHorizontalApertureAttr().Set((*product.aperture)[0]);
    camera.GetVerticalApertureAttr().Set((*product.aperture)[1]);
}

} // namespace stfrecord
