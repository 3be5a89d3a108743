// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/settings.h"

#include "pxr/base/gf/vec4f.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/base/work/threadLimits.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

const HdRenderSettingDescriptor* findSetting(const HdRenderSettingDescriptorList& list, const std::string& key) {
    for (const HdRenderSettingDescriptor& descriptor : list) {
        if (descriptor.key == key) {
            return &descriptor;
        }
    }
    return nullptr;
}

/// Text as a value of the default's type; empty if it cannot be read as that.
VtValue parseAs(const VtValue& type, const std::string& text) {
    if (type.IsHolding<std::string>()) {
        return VtValue(text);
    }
    if (type.IsHolding<TfToken>()) {
        return VtValue(TfToken(text));
    }
    if (type.IsHolding<bool>()) {
        const std::string lower = TfStringToLower(text);
        if (lower == "1" || lower == "true" || lower == "on" || lower == "yes") {
            return VtValue(true);
        }
        return lower == "0" || lower == "false" || lower == "off" || lower == "no" ? VtValue(false) : VtValue();
    }
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (text.empty() || end != text.c_str() + text.size() || !std::isfinite(number)) {
        return VtValue();
    }
    if (type.IsHolding<float>() || type.IsHolding<double>()) {
        return VtValue::CastToTypeOf(VtValue(number), type);
    }
    if (number != std::floor(number) || std::fabs(number) > double(std::numeric_limits<int>::max())) {
        return VtValue();
    }
    return VtValue::CastToTypeOf(VtValue(int(number)), type);
}

/// Sets the first of the names that the delegate offers.
bool setFirstOffered(HdRenderDelegate& delegate, const HdRenderSettingDescriptorList& list,
                     std::initializer_list<const char*> names, int number) {
    for (const char* name : names) {
        if (const HdRenderSettingDescriptor* setting = findSetting(list, name)) {
            delegate.SetRenderSetting(setting->key, VtValue::CastToTypeOf(VtValue(number), setting->defaultValue));
            return true;
        }
    }
    return false;
}

std::string settingNames(const HdRenderSettingDescriptorList& list) {
    std::vector<std::string> names;
    for (const HdRenderSettingDescriptor& descriptor : list) {
        names.push_back(descriptor.key.GetString());
    }
    return TfStringJoin(names, ", ");
}

} // namespace

std::string applySettings(HdRenderDelegate& delegate, const Options& options, double metersPerUnit) {
    const HdRenderSettingDescriptorList list = delegate.GetRenderSettingDescriptors();
    delegate.SetRenderSetting(TfToken("stageMetersPerUnit"), VtValue(metersPerUnit));
    delegate.SetRenderSetting(TfToken("enableInteractive"), VtValue(false));
    if (options.samples &&
        !setFirstOffered(delegate, list, {"stf:samples", "convergedSamplesPerPixel"}, *options.samples)) {
        return "this renderer has no setting for the samples per pixel";
    }
    if (options.seed && !setFirstOffered(delegate, list, {"stf:seed", "randomNumberSeed"}, *options.seed)) {
        return "this renderer has no setting for the seed";
    }
    if (options.threads) {
        setFirstOffered(delegate, list, {"stf:threads", "threadLimit"}, *options.threads);
        if (*options.threads > 0) {
            WorkSetConcurrencyLimit(unsigned(*options.threads));
        }
    }
    if (options.crop) {
        if (const std::string problem = setDataWindow(delegate, options.crop); !problem.empty()) {
            return problem;
        }
    }
    for (const auto& [key, text] : options.settings) {
        const HdRenderSettingDescriptor* setting = findSetting(list, key);
        if (!setting) {
            return "no render setting \"" + key + "\"; there are: " + settingNames(list);
        }
        // In the type the delegate keeps it in, which may be wider than the one it shows.
        const VtValue present = delegate.GetRenderSetting(setting->key);
        const VtValue value = parseAs(present.IsEmpty() ? setting->defaultValue : present, text);
        if (value.IsEmpty()) {
            return "render setting " + key + ": \"" + text + "\" is not of type " + setting->defaultValue.GetTypeName();
        }
        delegate.SetRenderSetting(setting->key, value);
    }
    return {};
}

std::string setDataWindow(HdRenderDelegate& delegate, const std::optional<std::array<float, 4>>& window) {
    // Not among the descriptors: panels have nothing to show it with. A delegate that has it has a value of it.
    const TfToken key("dataWindowNDC");
    const std::array<float, 4> c = window.value_or(std::array<float, 4>{0, 0, 1, 1});
    if (delegate.GetRenderSetting(key).IsEmpty()) {
        return window ? "this renderer has no setting dataWindowNDC: it cannot render a part of the frame"
                      : std::string();
    }
    const VtValue value(GfVec4f(c[0], c[1], c[2], c[3]));
    delegate.SetRenderSetting(key, value);
    return delegate.GetRenderSetting(key) == value ? std::string()
                                                   : "the renderer does not take that part of the frame";
}

std::vector<std::string> ProductSettings::apply(const VtDictionary& settings) {
    for (const auto& [key, value] : replaced_) {
        delegate_.SetRenderSetting(TfToken(key), value);
    }
    replaced_.clear();
    const HdRenderSettingDescriptorList list = delegate_.GetRenderSettingDescriptors();
    std::vector<std::string> problems;
    for (const auto& [key, value] : settings) {
        const TfToken token(key);
        if (!findSetting(list, key)) {
            problems.push_back("the renderer has no setting " + key + ", it is left out");
            continue;
        }
        replaced_[key] = delegate_.GetRenderSetting(token);
        delegate_.SetRenderSetting(token, value);
    }
    return problems;
}

std::string describeSettings(const HdRenderDelegate& delegate) {
    std::ostringstream text;
    for (const HdRenderSettingDescriptor& descriptor : delegate.GetRenderSettingDescriptors()) {
        text << (text.tellp() > 0 ? " " : "") << descriptor.key << "=" << delegate.GetRenderSetting(descriptor.key);
    }
    return text.str();
}

} // namespace stfrecord
