// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"

#include <chrono>
#include <mutex>

namespace stf {

/// Progress of a command: a line on the error stream with the share done and the time left, where that is a terminal
/// and it is wanted; an interrupt (Ctrl-C) cancels. One at a time.
class TerminalProgress : public Progress {
public:
    explicit TerminalProgress(bool wanted);
    ~TerminalProgress() override;
    bool cancelled() const override;

private:
    void show(const std::string& stage, double fraction);

    bool shown_ = false, visible_;
    std::mutex mutex_;
    std::string stage_;
    double lastFraction_ = 0;
    std::chrono::steady_clock::time_point start_, last_;
    void (*before_)(int); ///< what an interrupt did before
};

} // namespace stf
