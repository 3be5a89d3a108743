// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/console.h"

#include <algorithm>
#include <cstdio>
#include <unistd.h>

namespace stfrecord {
namespace {
constexpr double terminalInterval = 0.1; // seconds between redraws of the bar
constexpr double logInterval = 10;       // seconds between lines in a log
} // namespace

Console::Console(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

bool Console::add(const std::string& severity, const std::string& text, bool countsAsError) {
    errors_ = errors_ || countsAsError;
    if (!seen_.insert(text).second) {
        // Said again by one who knows better how bad it is.
        for (Message& said : messages_) {
            if (said.text == text && countsAsError) {
                said.severity = severity;
            }
        }
        return false;
    }
    messages_.push_back({severity, text});
    return true;
}

void Console::clearLine() {
    if (lineOpen_) {
        std::fputs("\r\033[K", stderr);
        lineOpen_ = false;
    }
}

void Console::message(const std::string& severity, const std::string& text, bool countsAsError) {
    std::lock_guard<std::mutex> lock(mutex_);
    if (!add(severity, text, countsAsError) || (quiet_ && !countsAsError)) {
        return;
    }
    print(severity, text);
}

void Console::note(const std::string& severity, const std::string& text, bool countsAsError) {
    std::lock_guard<std::mutex> lock(mutex_);
    add(severity, text, countsAsError);
    if (quiet_ && countsAsError) {
        print(severity, text); // it came as a warning before, which --quiet hides
    }
}

void Console::print(const std::string& severity, const std::string& text) {
    if (printed_.insert(text).second) {
        clearLine();
        std::fprintf(stderr, "stfrecord: %s: %s\n", severity.c_str(), text.c_str());
    }
}

void Console::progress(const std::string& what, double fraction, const std::string& annotation) {
    std::lock_guard<std::mutex> lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    const double elapsed = std::chrono::duration<double>(now - lastProgress_).count();
    if (quiet_ || (what == lastWhat_ && elapsed < (terminal_ ? terminalInterval : logInterval))) {
        return;
    }
    lastProgress_ = now;
    lastWhat_ = what;
    const double bounded = std::min(1.0, std::max(0.0, fraction));
    if (!terminal_) {
        std::fprintf(stderr, "%s: %3.0f %%  %s\n", what.c_str(), 100 * bounded, annotation.c_str());
        return;
    }
    constexpr int width = 30;
    const int filled = int(bounded * width);
    clearLine();
    std::fprintf(stderr, "%s [%s%s] %3.0f %%  %s", what.c_str(), std::string(std::size_t(filled), '#').c_str(),
                 std::string(std::size_t(width - filled), '.').c_str(), 100 * bounded, annotation.c_str());
    std::fflush(stderr);
    lineOpen_ = true;
}

void Console::done(const std::string& text) {
    std::lock_guard<std::mutex> lock(mutex_);
    clearLine();
    if (!quiet_) {
        std::fprintf(stderr, "%s\n", text.c_str());
    }
}

std::vector<Message> Console::messages() const {
    std::lock_guard<std::mutex> lock(mutex_);
    return messages_;
}

bool Console::anyErrors() const {
    std::lock_guard<std::mutex> lock(mutex_);
    return errors_;
}

} // namespace stfrecord
