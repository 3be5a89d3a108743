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

void Diagnostics::IssueError(const PXR_NS::TfError& error) {
    console_.message("error", error.GetCommentary(), true);
}

void Diagnostics::IssueFatalError(const PXR_NS::TfCallContext&, const std::string& message) {
    console_.message("error", message, true);
    _UnhandledAbort();
}

void Diagnostics::IssueStatus(const PXR_NS::TfStatus& status) {
    console_.message("info", status.GetCommentary(), false);
}

void Diagnostics::IssueWarning(const PXR_NS::TfWarning& warning) {
    console_.message("warning", warning.GetCommentary(), meansLoss(warning));
}

} // namespace stfrecord
