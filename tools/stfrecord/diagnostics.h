// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/console.h"

#include "pxr/base/tf/diagnosticMgr.h"

namespace stfrecord {

/// Sends what OpenUSD says, on any of its threads, to the console. Installed while it lives. While it holds back, what
/// is said is kept: one failure in OpenUSD makes several errors, and the caller has one sentence to say.
class Diagnostics final : public PXR_NS::TfDiagnosticMgr::Delegate {
public:
    explicit Diagnostics(Console& console);
    ~Diagnostics() override;

    void holdBack();
    /// Ends that. Returns the first error kept back, or nothing; everything else kept goes to the console unless there
    /// was an error.
    std::string release();

    void IssueError(const PXR_NS::TfError& error) override;
    void IssueFatalError(const PXR_NS::TfCallContext& context, const std::string& message) override;
    void IssueStatus(const PXR_NS::TfStatus& status) override;
    void IssueWarning(const PXR_NS::TfWarning& warning) override;

private:
    struct Kept {
        Message message;
        bool countsAsError;
    };
    void say(const std::string& severity, const std::string& text, bool countsAsError);

    Console& console_;
    std::mutex mutex_;
    bool holding_ = false;
    std::vector<Kept> kept_;
};

} // namespace stfrecord
