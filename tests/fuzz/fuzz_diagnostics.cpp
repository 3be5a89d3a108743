// SPDX-License-Identifier: Apache-2.0
#include "fuzz_diagnostics.h"

#include "pxr/base/tf/diagnosticMgr.h"
#include "pxr/base/tf/error.h"

#include <iostream>
#include <map>
#include <mutex>
#include <string>

PXR_NAMESPACE_USING_DIRECTIVE

namespace fuzz {

class Diagnostics::Collector final : public TfDiagnosticMgr::Delegate {
public:
    void IssueError(const TfError& error) override {
        const std::string file = error.GetSourceFileName();
        const std::lock_guard<std::mutex> lock(mutex_);
        ++errors_[file.substr(file.rfind('/') + 1) + ":" + std::to_string(error.GetSourceLineNumber()) + ": " +
                  error.GetCommentary()];
        own_ = own_ || file.find("hdStf/") != std::string::npos;
    }
    void IssueFatalError(const TfCallContext&, const std::string& text) override { std::cerr << text << "\n"; }
    void IssueStatus(const TfStatus&) override {}
    void IssueWarning(const TfWarning&) override {}

    bool print() const {
        const std::lock_guard<std::mutex> lock(mutex_);
        for (const auto& [text, count] : errors_) {
            std::cout << "error reported " << count << " times: " << text << "\n";
        }
        return !own_;
    }

private:
    mutable std::mutex mutex_;
    std::map<std::string, int> errors_;
    bool own_ = false;
};

Diagnostics::Diagnostics() : collector_(std::make_unique<Collector>()) {
    TfDiagnosticMgr::GetInstance().AddDelegate(collector_.get());
}

Diagnostics::~Diagnostics() {
    TfDiagnosticMgr::GetInstance().RemoveDelegate(collector_.get());
}

bool Diagnostics::print() const {
    return collector_->print();
}

} // namespace fuzz
