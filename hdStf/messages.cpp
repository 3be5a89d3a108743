// SPDX-License-Identifier: Apache-2.0
#include "hdStf/messages.h"

#include "pxr/base/tf/diagnostic.h"

PXR_NAMESPACE_OPEN_SCOPE

void HdStfMessages::Report(stf::Severity severity, std::string const& text) {
    {
        std::lock_guard<std::mutex> lock(_mutex);
        if (!_seen.insert(text).second) {
            return;
        }
        _messages.push_back({severity, text});
    }
    if (severity != stf::Severity::Info) {
        TF_WARN("%s", text.c_str());
    }
}

std::vector<HdStfMessages::Message> HdStfMessages::Get() const {
    std::lock_guard<std::mutex> lock(_mutex);
    return _messages;
}

char const* HdStfSeverityName(stf::Severity severity) {
    switch (severity) {
    case stf::Severity::Info:
        return "info";
    case stf::Severity::Warning:
        return "warning";
    case stf::Severity::Error:
        break;
    }
    return "error";
}

PXR_NAMESPACE_CLOSE_SCOPE
