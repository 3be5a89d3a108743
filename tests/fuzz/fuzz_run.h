// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fuzz_session.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fuzz {

/// One step: an edit of a kind with a seed of its own, or a comparison.
struct Step {
    int number = 0; ///< in the whole run
    int kind = 0;   ///< of editKinds(); -1: compare
    std::uint64_t seed = 0;
};

/// Steps by a seed: kinds by their weights, a comparison after every few edits and at the end. `only`: kinds whose name
/// starts with it, and those that execute.
std::vector<Step> makeSteps(std::uint64_t seed, int count, const std::string& only);

/// What became of a run.
struct Outcome {
    int steps = 0, edits = 0, comparisons = 0;
    std::map<std::string, int> applied; ///< edits by kind, those that found nothing to edit left out
    std::optional<int> failedStep;      ///< index into the steps
    std::string difference;
};

/// Goes through the steps on a new stage until a comparison differs or the time is over. `say` gets each step.
Outcome run(const std::vector<Step>& steps, Sabotage sabotage, const std::function<void(const std::string&)>& say,
            std::chrono::steady_clock::time_point end);

/// Leaves out what can be left out of steps of which the last comparison differs, until nothing more can or the time is
/// over.
std::vector<Step> shorten(std::vector<Step> steps, Sabotage sabotage, std::chrono::steady_clock::time_point end);

} // namespace fuzz
