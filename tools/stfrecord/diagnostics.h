// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/console.h"

#include "pxr/base/tf/diagnosticMgr.h"

namespace stfrecord {

/// Sends what OpenUSD says, on any of its threads, to the console. Installed while it lives.
class Diagnostics final : public PXR_NS::TfDiagnosticMgr::Delegate {
public:
    explicit Diagnostics(Console& console);
    ~Diagnostics() override;

    void IssueError(const PXR_NS::TfError& error) override;
    void IssueFatalError(const PXR_NS::TfCallContext& context, const std::string& message) override;
    void IssueStatus(const PXR_NS::TfStatus& status) override;
    void IssueWarning(const PXR_NS::TfWarning& warning) override;

private:
    Console& console_;
};

} // namespace stfrecord
