// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

namespace stf {

/// What went wrong, in one sentence for the person at the screen. Whoever catches it adds the prim.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Thrown by a long stage after `Progress::cancelled()` became true. Nothing partial is kept.
class Cancelled : public std::exception {
public:
    const char* what() const noexcept override { return "cancelled"; }
};

enum class Severity { Info, Warning, Error };

/// Receives messages of a stage; may be called from any thread. An empty function discards them.
using MessageSink = std::function<void(Severity, const std::string&)>;

inline void report(const MessageSink& sink, Severity severity, const std::string& text) {
    if (sink) {
        sink(severity, text);
    }
}

} // namespace stf
