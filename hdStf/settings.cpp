// SPDX-License-Identifier: Apache-2.0
#include "hdStf/settings.h"

#include "hdStf/settingTable.h"

#include "pxr/base/gf/vec4f.h"
#include "pxr/base/tf/getenv.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <type_traits>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Hosts hand numbers over as text, too (Houdini's parameters, command lines).
VtValue _FromText(VtValue const& value) {
    if (!value.IsHolding<std::string>()) {
        return value;
    }
    std::string const& text = value.UncheckedGet<std::string>();
    if (std::optional<bool> const flag = stf::flagOfText(text)) {
        return VtValue(*flag);
    }
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    return !text.empty() && end == text.c_str() + text.size() ? VtValue(number) : value;
}

/// A value in the type of another; empty where that cannot be, as for numbers that are none.
VtValue _OfType(VtValue const& value, VtValue const& other) {
    const VtValue given = _FromText(value);
    if (given.IsHolding<double>() && !std::isfinite(given.UncheckedGet<double>())) {
        return VtValue();
    }
    if (other.IsHolding<bool>() && given.CanCast<double>()) {
        // Which numbers are flags differs between OpenUSD's versions.
        const double number = VtValue::Cast<double>(given).UncheckedGet<double>();
        return number > -1 && number < 2 ? VtValue(static_cast<int>(number) != 0) : VtValue();
    }
    return VtValue::CastToTypeOf(given, other);
}

bool _IsWindow(GfVec4f const& window) {
    for (int i = 0; i < 4; ++i) {
        // Sixteen frames' worth of overscan bounds what a wrong number may cost.
        if (!std::isfinite(window[i]) || std::abs(window[i]) >= 16) {
            return false;
        }
    }
    return window[2] > window[0] && window[3] > window[1];
}

/// A value of the setting's type, within its range; empty where it is outside and is refused there.
VtValue _InRange(stf::SettingRow const& row, VtValue const& value) {
    if (value.IsHolding<std::string>()) {
        return stf::settingChooses(row, value.UncheckedGet<std::string>()) ? value : VtValue();
    }
    if (value.IsHolding<GfVec4f>()) {
        return _IsWindow(value.UncheckedGet<GfVec4f>()) ? value : VtValue();
    }
    const bool isNumber = value.IsHolding<int>() || value.IsHolding<float>() || value.IsHolding<double>();
    if (!isNumber) {
        return value;
    }
    const VtValue asDouble = VtValue::Cast<double>(value);
    const double number = asDouble.UncheckedGet<double>();
    if (stf::settingHolds(row, number)) {
        return value;
    }
    if (row.outside == stf::SettingRow::Outside::Refused || std::isnan(number)) {
        return VtValue();
    }
    return VtValue::CastToTypeOf(VtValue(std::min(std::max(number, row.least), row.most)), value);
}

/// The row of a key; null: no setting of this delegate.
stf::SettingRow const* _FindRow(TfToken const& key) {
    for (stf::SettingRow const& row : stf::settingTable()) {
        if (key == row.key) {
            return &row;
        }
    }
    return nullptr;
}

VtValue _OwnValue(stf::SettingRow const& row) {
    return std::visit(
        [](auto const& own) {
            if constexpr (std::is_same_v<std::decay_t<decltype(own)>, std::array<float, 4>>) {
                return VtValue(GfVec4f(own.data()));
            } else {
                return VtValue(own);
            }
        },
        row.own);
}

/// The default: what the environment says, by the same types and ranges as everybody's values, or the setting's own.
VtValue _Default(stf::SettingRow const& row) {
    const VtValue own = _OwnValue(row);
    const std::string text = row.variable.empty() ? std::string() : TfGetenv(row.variable);
    if (text.empty()) {
        return own;
    }
    const VtValue typed = _OfType(VtValue(text), own);
    const VtValue given = typed.IsEmpty() ? typed : _InRange(row, typed);
    if (given.IsEmpty()) {
        TF_WARN("environment variable %s = \"%s\" is no value of %s; using %s", row.variable.c_str(), text.c_str(),
                row.key.c_str(), stf::settingText(row.own).c_str());
        return own;
    }
    return given;
}

} // namespace

HdRenderSettingDescriptorList HdStfMakeSettingDescriptors() {
    HdRenderSettingDescriptorList list;
    for (stf::SettingRow const& row : stf::settingTable()) {
        list.push_back({row.name, TfToken(row.key), _Default(row)});
    }
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
    stf::SettingRow const* const row = _FindRow(key);
    for (HdRenderSettingDescriptor const& descriptor : descriptors) {
        if (row && descriptor.key == key) {
            const VtValue typed = _OfType(value, descriptor.defaultValue);
            return typed.IsEmpty() ? VtValue() : _InRange(*row, typed);
        }
    }
    return VtValue();
}

PXR_NAMESPACE_CLOSE_SCOPE
