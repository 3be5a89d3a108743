// SPDX-License-Identifier: Apache-2.0
#include "hdStf/settings.h"

#include "hdStf/tokens.h"
#include "stfLib/render/pixel_filter.h"

#include "pxr/base/gf/vec4f.h"
#include "pxr/base/tf/getenv.h"
#include "pxr/base/tf/stringUtils.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Hosts hand numbers over as text, too (Houdini's parameters, command lines).
VtValue _FromText(VtValue const& value) {
    if (!value.IsHolding<std::string>()) {
        return value;
    }
    std::string const& text = value.UncheckedGet<std::string>();
    if (text == "true" || text == "false") {
        return VtValue(text == "true");
    }
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    return !text.empty() && end == text.c_str() + text.size() ? VtValue(number) : value;
}

VtValue _InRange(TfToken const& key, VtValue const& value) {
    if (key == HdStfRenderSettingsTokens->samples) {
        return VtValue(std::max(1, value.UncheckedGet<int>()));
    }
    if (key == HdStfRenderSettingsTokens->errorTarget) {
        const float target = value.UncheckedGet<float>();
        return target >= 0 && std::isfinite(target) ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->threads) {
        return VtValue(std::max(0, value.UncheckedGet<int>()));
    }
    if (key == HdStfRenderSettingsTokens->maxDepth) {
        return VtValue(std::max(0, value.UncheckedGet<int>()));
    }
    if (key == HdStfRenderSettingsTokens->indirectClamp) {
        const float most = value.UncheckedGet<float>();
        return most >= 0 && std::isfinite(most) ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->quality) {
        const float quality = value.UncheckedGet<float>();
        return quality > 0 && std::isfinite(quality) ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->transport) {
        std::string const& form = value.UncheckedGet<std::string>();
        return form == "dE1" || form == "classic" ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->integrator) {
        std::string const& name = value.UncheckedGet<std::string>();
        return name == "stf" || name == "reference" ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->pixelFilter) {
        stf::PixelFilter::Shape shape;
        return stf::PixelFilter::shapeFromName(value.UncheckedGet<std::string>(), shape) ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->pixelFilterWidth) {
        const float width = value.UncheckedGet<float>();
        return width >= 0 && width <= 64 ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->dataWindowNDC) {
        const GfVec4f window = value.UncheckedGet<GfVec4f>();
        const bool finite = std::isfinite(window[0]) && std::isfinite(window[1]) && std::isfinite(window[2]) &&
                            std::isfinite(window[3]);
        // Sixteen frames' worth of overscan bounds what a wrong number may cost.
        const bool bounded = finite && std::abs(window[0]) < 16 && std::abs(window[1]) < 16 &&
                             std::abs(window[2]) < 16 && std::abs(window[3]) < 16;
        return bounded && window[2] > window[0] && window[3] > window[1] ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->stageMetersPerUnit) {
        const double meters = value.UncheckedGet<double>();
        return meters > 0 && std::isfinite(meters) ? value : VtValue();
    }
    return value;
}

} // namespace

HdRenderSettingDescriptorList HdStfMakeSettingDescriptors() {
    HdRenderSettingDescriptorList list;
    // A default of the environment obeys the same types and ranges as everybody's values.
    const auto add = [&list](char const* name, TfToken const& key, VtValue const& own, char const* variable) {
        VtValue value = own;
        if (const std::string text = variable ? TfGetenv(variable) : std::string(); !text.empty()) {
            const VtValue typed = VtValue::CastToTypeOf(_FromText(VtValue(text)), own);
            const VtValue given = typed.IsEmpty() ? typed : _InRange(key, typed);
            if (given.IsEmpty()) {
                TF_WARN("environment variable %s = \"%s\" is no value of %s; using %s", variable, text.c_str(),
                        key.GetText(), TfStringify(own).c_str());
            } else {
                value = given;
            }
        }
        list.push_back({name, key, value});
    };
    auto const& keys = HdStfRenderSettingsTokens;
    add("Samples per pixel", keys->samples, VtValue(64), "HDSTF_SAMPLES");
    add("Wanted error of a pixel (0 = off)", keys->errorTarget, VtValue(0.0f), "HDSTF_ERROR_TARGET");
    add("Seed", keys->seed, VtValue(0), "HDSTF_SEED");
    add("Target error of the tables", keys->quality, VtValue(0.02f), "HDSTF_QUALITY");
    add("Seed of the tables", keys->tableSeed, VtValue(0), "HDSTF_TABLE_SEED");
    add("Form of transport (dE1, classic)", keys->transport, VtValue(std::string("dE1")), "HDSTF_TRANSPORT");
    add("Integrator (stf, reference)", keys->integrator, VtValue(std::string("stf")), "HDSTF_INTEGRATOR");
    add("Bounces off surfaces without a shell", keys->maxDepth, VtValue(4), "HDSTF_MAX_DEPTH");
    add("Most light of a bounced path (0 = no limit)", keys->indirectClamp, VtValue(0.0f), "HDSTF_INDIRECT_CLAMP");
    add("Blur what paths of bounces find too rarely", keys->regularize, VtValue(true), "HDSTF_REGULARIZE");
    add("Pixel filter (box, triangle, gaussian, blackmanHarris)", keys->pixelFilter,
        VtValue(std::string("blackmanHarris")), "HDSTF_PIXEL_FILTER");
    add("Width of the pixel filter (0 = its own)", keys->pixelFilterWidth, VtValue(0.0f), "HDSTF_PIXEL_FILTER_WIDTH");
    add("Depth of field", keys->depthOfField, VtValue(true), "HDSTF_DEPTH_OF_FIELD");
    add("Keep light between surfaces at samples of shells", keys->irradianceCache, VtValue(true),
        "HDSTF_IRRADIANCE_CACHE");
    add("Motion blur", keys->motionBlur, VtValue(true), "HDSTF_MOTION_BLUR");
    add("Denoise the finished colour", keys->denoise, VtValue(false), "HDSTF_DENOISE");
    add("Data window (x and y from, to; shares of the frame)", keys->dataWindowNDC, VtValue(GfVec4f(0, 0, 1, 1)),
        nullptr);
    add("Threads (0 = all cores)", keys->threads, VtValue(0), "HDSTF_THREADS");
    add("Metres per scene unit", keys->stageMetersPerUnit, VtValue(0.01), "HDSTF_STAGE_METERS_PER_UNIT");
    return list;
}

HdRenderSettingDescriptorList HdStfPanelDescriptors(HdRenderSettingDescriptorList const& descriptors) {
    HdRenderSettingDescriptorList shown;
    for (HdRenderSettingDescriptor descriptor : descriptors) {
        if (descriptor.defaultValue.IsHolding<double>()) {
            descriptor.defaultValue = VtValue::Cast<float>(descriptor.defaultValue);
        }
        if (!descriptor.defaultValue.IsHolding<GfVec4f>()) {
            shown.push_back(descriptor);
        }
    }
    return shown;
}

VtValue HdStfNormalizeSetting(HdRenderSettingDescriptorList const& descriptors, TfToken const& key,
                              VtValue const& value) {
    for (HdRenderSettingDescriptor const& descriptor : descriptors) {
        if (descriptor.key == key) {
            const VtValue typed = VtValue::CastToTypeOf(_FromText(value), descriptor.defaultValue);
            return typed.IsEmpty() ? VtValue() : _InRange(key, typed);
        }
    }
    return VtValue();
}

PXR_NAMESPACE_CLOSE_SCOPE
