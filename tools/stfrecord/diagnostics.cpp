// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/diagnostics.h"

#include "pxr/base/tf/error.h"
#include "pxr/base/tf/status.h"
#include "pxr/base/tf/stringUtils.h"
#include "pxr/base/tf/warning.h"

namespace stfrecord {
namespace {

/// Warnings that mean that something is missing in the image: composition (a reference that cannot be opened).
bool meansLoss(const PXR_NS::TfWarning& warning) {
    return PXR_NS::TfStringEndsWith(warning.GetSourceFileName(), "usd/stage.cpp");
}

} // namespace

Diagnostics::Diagnostics(Console& console) : console_(console) {
    PXR_NS::TfDiagnosticMgr::GetInstance().AddDelegate(this);
}

Diagnostics::~Diagnostics() {
    PXR_NS::TfDiagnosticMgr::GetInstance().RemoveDelegate(this);
}

void Diagnostics::holdBack() {
    std::lock_guard<std::mutex> lock(mutex_);
    holding_ = true;
}

std::string Diagnostics::release() {
    std::vector<Kept> kept;
    {
        std::lock_guard<std::mutex> lock(mutex_);
        holding_ = false;
        kept.swap(kept_);
    }
    for (const Kept& k : kept) {
        if (k.message.severity == "error") {
            return k.message.text;
        }
    }
    for (const Kept& k : kept) {
        console_.message(k.message.severity, k.message.text, k.countsAsError);
    }
    return {};
}

void Diagnostics::say(const std::string& severity, const std::string& text, bool countsAsError) {
    {
        std::lock_guard<std::mutex> lock(mutex_);
        if (holding_) {
            kept_.push_back({{severity, text}, countsAsError});
            return;
        }
    }
    console_.message(severity, text, countsAsError);
}

void Diagnostics::IssueError(const PXR_NS::TfError& error) {
    say("error", error.GetCommentary(), true);
}

void Diagnostics::IssueFatalError(const PXR_NS::TfCallContext&, const std::string& message) {
    console_.message("error", message, true);
    _UnhandledAbort();
}

void Diagnostics::IssueStatus(const PXR_NS::TfStatus& status) {
    say("info", status.GetCommentary(), false);
}

void Diagnostics::IssueWarning(const PXR_NS::TfWarning& warning) {
    say("warning", warning.GetCommentary(), meansLoss(warning));
}

} // namespace stfrecord
