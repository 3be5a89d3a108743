// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/terminal_progress.h"

#include <csignal>
#include <cstdio>
#include <unistd.h>

namespace stf {

namespace {
volatile std::sig_atomic_t interrupted = 0;
} // namespace

TerminalProgress::TerminalProgress(bool wanted)
    : Progress([this](const std::string& stage, double fraction) { show(stage, fraction); }),
      visible_(wanted && isatty(2)) {
    interrupted = 0;
    before_ = std::signal(SIGINT, [](int) { interrupted = 1; });
}

TerminalProgress::~TerminalProgress() {
    std::signal(SIGINT, before_ == SIG_ERR ? SIG_DFL : before_);
    if (shown_) {
        std::fprintf(stderr, "\r%60s\r", "");
    }
}

bool TerminalProgress::cancelled() const {
    return interrupted || Progress::cancelled();
}

void TerminalProgress::show(const std::string& stage, double fraction) {
    if (!visible_) {
        return;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (stage != stage_ || fraction < lastFraction_) {
        stage_ = stage;
        start_ = last_ = now;
    }
    lastFraction_ = fraction;
    const double gone = std::chrono::duration<double>(now - start_).count();
    if (std::chrono::duration<double>(now - last_).count() < 0.2 || fraction <= 0) {
        return;
    }
    last_ = now;
    shown_ = true;
    std::fprintf(stderr, "\r%-12s %5.1f %%, %.0f s left   ", stage.c_str(), 100 * fraction,
                 gone * (1 - fraction) / fraction);
}

} // namespace stf
