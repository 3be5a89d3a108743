// SPDX-License-Identifier: Apache-2.0
#include "hdStf/settings.h"

#include "hdStf/tokens.h"

#include "pxr/base/tf/getenv.h"
#include "pxr/base/tf/stringUtils.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// A number from the environment, or the default where there is none or it is not one.
double _EnvNumber(char const* name, double defaultValue) {
    const std::string text = TfGetenv(name);
    if (text.empty()) {
        return defaultValue;
    }
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (end != text.c_str() + text.size() || !std::isfinite(number)) {
        TF_WARN("environment variable %s = \"%s\" is not a number; using %g", name, text.c_str(), defaultValue);
        return defaultValue;
    }
    return number;
}

/// Hosts hand numbers over as text, too (Houdini's parameters, command lines).
VtValue _FromText(VtValue const& value) {
    if (!value.IsHolding<std::string>()) {
        return value;
    }
    std::string const& text = value.UncheckedGet<std::string>();
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
    if (key == HdStfRenderSettingsTokens->quality) {
        const float quality = value.UncheckedGet<float>();
        return quality > 0 && std::isfinite(quality) ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->transport) {
        std::string const& form = value.UncheckedGet<std::string>();
        return form == "dE1" || form == "classic" ? value : VtValue();
    }
    if (key == HdStfRenderSettingsTokens->stageMetersPerUnit) {
        const double meters = value.UncheckedGet<double>();
        return meters > 0 && std::isfinite(meters) ? value : VtValue();
    }
    return value;
}

} // namespace

HdRenderSettingDescriptorList HdStfMakeSettingDescriptors() {
    HdRenderSettingDescriptorList list = {
        {"Samples per pixel", HdStfRenderSettingsTokens->samples,
         VtValue(static_cast<int>(_EnvNumber("HDSTF_SAMPLES", 64)))},
        {"Wanted error of a pixel (0 = off)", HdStfRenderSettingsTokens->errorTarget,
         VtValue(static_cast<float>(_EnvNumber("HDSTF_ERROR_TARGET", 0)))},
        {"Seed", HdStfRenderSettingsTokens->seed, VtValue(static_cast<int>(_EnvNumber("HDSTF_SEED", 0)))},
        {"Target error of the tables", HdStfRenderSettingsTokens->quality,
         VtValue(static_cast<float>(_EnvNumber("HDSTF_QUALITY", 0.02)))},
        {"Form of transport (dE1, classic)", HdStfRenderSettingsTokens->transport,
         VtValue(TfGetenv("HDSTF_TRANSPORT", "dE1"))},
        {"Threads (0 = all cores)", HdStfRenderSettingsTokens->threads,
         VtValue(static_cast<int>(_EnvNumber("HDSTF_THREADS", 0)))},
        {"Metres per scene unit", HdStfRenderSettingsTokens->stageMetersPerUnit,
         VtValue(_EnvNumber("HDSTF_STAGE_METERS_PER_UNIT", 0.01))},
    };
    // The environment obeys the same ranges as everybody.
    for (HdRenderSettingDescriptor& descriptor : list) {
        if (_InRange(descriptor.key, descriptor.defaultValue).IsEmpty()) {
            descriptor.defaultValue = descriptor.key == HdStfRenderSettingsTokens->quality       ? VtValue(0.02f)
                                      : descriptor.key == HdStfRenderSettingsTokens->errorTarget ? VtValue(0.0f)
                                      : descriptor.key == HdStfRenderSettingsTokens->transport
                                          ? VtValue(std::string("dE1"))
                                          : VtValue(0.01);
        } else {
            descriptor.defaultValue = _InRange(descriptor.key, descriptor.defaultValue);
        }
    }
    return list;
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
