// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace stf::doctor {

/// One thing that was looked at.
struct Finding {
    enum class State {
        Ok,
        Warning, ///< works, but not as it might be meant
        Problem  ///< keeps hosts from showing or running the renderer
    };
    State state = State::Ok;
    std::string topic; ///< "plugin path", "cache", ...
    std::string text;  ///< what was found, without a full stop
    std::string todo;  ///< what to do about it; empty where nothing is to be done
};
using Findings = std::vector<Finding>;

inline Finding ok(std::string topic, std::string text) {
    return {Finding::State::Ok, std::move(topic), std::move(text), {}};
}
inline Finding warning(std::string topic, std::string text, std::string todo) {
    return {Finding::State::Warning, std::move(topic), std::move(text), std::move(todo)};
}
inline Finding problem(std::string topic, std::string text, std::string todo) {
    return {Finding::State::Problem, std::move(topic), std::move(text), std::move(todo)};
}

} // namespace stf::doctor
