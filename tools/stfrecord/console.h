// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace stfrecord {

/// What was said during a run, for people and for the statistics.
struct Message {
    std::string severity; ///< info, warning, error
    std::string text;
};

/// Standard error of stfrecord: messages, each text once, and progress: a bar that redraws itself on a terminal, a line
/// every now and then otherwise. Thread-safe.
class Console {
public:
    explicit Console(bool quiet);

    /// `countsAsError`: something was left out of the image, or went wrong.
    void message(const std::string& severity, const std::string& text, bool countsAsError);
    /// The same without printing (already printed by other means), but for an error that --quiet has hidden.
    void note(const std::string& severity, const std::string& text, bool countsAsError);
    void progress(const std::string& what, double fraction, const std::string& annotation);
    /// Ends the progress of one frame with a line that stays.
    void done(const std::string& text);

    std::vector<Message> messages() const;
    bool anyErrors() const;

private:
    bool add(const std::string& severity, const std::string& text, bool countsAsError);
    void print(const std::string& severity, const std::string& text);
    void clearLine();

    mutable std::mutex mutex_;
    bool quiet_, terminal_;
    bool lineOpen_ = false;
    bool errors_ = false;
    std::set<std::string> seen_, printed_;
    std::vector<Message> messages_;
    std::chrono::steady_clock::time_point lastProgress_;
    std::string lastWhat_;
};

} // namespace stfrecord
