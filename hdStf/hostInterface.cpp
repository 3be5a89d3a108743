// SPDX-License-Identifier: Apache-2.0
#include "hdStf/hostInterface.h"

#include "hdStf/renderDelegate.h"
#include "hdStf/settingTable.h"
#include "hdStf/settings.h"
#include "hdStf/tokens.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

struct _Delegates {
    std::mutex mutex;
    std::vector<HdStfRenderDelegate const*> list;
};

_Delegates& _GetDelegates() {
    static _Delegates delegates;
    return delegates;
}

size_t _Copy(nlohmann::json const& json, char* buffer, size_t size) {
    const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (buffer && size > 0) {
        const size_t count = std::min(size - 1, text.size());
        std::memcpy(buffer, text.data(), count);
        buffer[count] = 0;
    }
    return text.size() + 1;
}

nlohmann::json _Json(VtValue const& value) {
    if (value.IsHolding<bool>()) {
        return value.UncheckedGet<bool>();
    }
    if (value.IsHolding<int>()) {
        return value.UncheckedGet<int>();
    }
    if (value.IsHolding<std::string>()) {
        return value.UncheckedGet<std::string>();
    }
    const VtValue number = VtValue::Cast<double>(value);
    return number.IsEmpty() ? nlohmann::json() : nlohmann::json(number.UncheckedGet<double>());
}

/// Meanings are written in Markdown.
std::string _Plain(std::string text) {
    text.erase(std::remove(text.begin(), text.end(), '`'), text.end());
    return text;
}

nlohmann::json _Settings() {
    nlohmann::json list = nlohmann::json::array();
    for (HdRenderSettingDescriptor const& setting : HdStfPanelDescriptors(HdStfMakeSettingDescriptors())) {
        nlohmann::json json{
            {"key", setting.key.GetString()}, {"name", setting.name}, {"default", _Json(setting.defaultValue)}};
        for (stf::SettingRow const& row : stf::settingTable()) {
            if (setting.key != row.key) {
                continue;
            }
            json["description"] = _Plain(row.meaning);
            if (std::isfinite(row.least)) {
                json["least"] = row.least;
            }
            if (std::isfinite(row.most)) {
                json["most"] = row.most;
            }
            if (!row.choices.empty() && !row.several) {
                json["choices"] = row.choices;
            }
        }
        list.push_back(json);
    }
    return list;
}

nlohmann::json _Status(HdStfRenderDelegate const& delegate) {
    const VtDictionary stats = delegate.GetRenderStats();
    nlohmann::json status;
    status["annotation"] = VtDictionaryGet<std::string>(stats, HdStfStatsTokens->renderProgressAnnotation.GetString());
    status["percentDone"] = VtDictionaryGet<double>(stats, HdStfStatsTokens->percentDone.GetString());
    status["messages"] =
        nlohmann::json::parse(VtDictionaryGet<std::string>(stats, HdStfStatsTokens->messages.GetString()));
    return status;
}

} // namespace

void HdStfAnnounceDelegate(HdStfRenderDelegate const* delegate) {
    _Delegates& delegates = _GetDelegates();
    std::lock_guard<std::mutex> lock(delegates.mutex);
    delegates.list.push_back(delegate);
}

void HdStfRetireDelegate(HdStfRenderDelegate const* delegate) {
    _Delegates& delegates = _GetDelegates();
    std::lock_guard<std::mutex> lock(delegates.mutex);
    auto& list = delegates.list;
    list.erase(std::remove(list.begin(), list.end(), delegate), list.end());
}

PXR_NAMESPACE_CLOSE_SCOPE

PXR_NAMESPACE_USING_DIRECTIVE

// No exception may leave a C function.
size_t hdStfSettingsJson(char* buffer, size_t size) try { return _Copy(_Settings(), buffer, size); } catch (...) {
    return 0;
}

size_t hdStfStatusJson(char* buffer, size_t size) try {
    _Delegates& delegates = _GetDelegates();
    // Held for all of it: a delegate waits here before it goes.
    std::lock_guard<std::mutex> lock(delegates.mutex);
    return _Copy(delegates.list.empty() ? nlohmann::json::object() : _Status(*delegates.list.back()), buffer, size);
} catch (...) {
    return 0;
}
