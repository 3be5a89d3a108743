// SPDX-License-Identifier: Apache-2.0
#include "fuzz_run.h"

#include "edits.h"

namespace fuzz {

namespace {

using Clock = std::chrono::steady_clock;

bool executes(const std::string& name) {
    return name.rfind("execute", 0) == 0;
}

} // namespace

std::vector<Step> makeSteps(std::uint64_t seed, int count, const std::string& only) {
    std::vector<int> kinds; // as often as they weigh
    for (int i = 0; i < int(editKinds().size()); ++i) {
        const EditKind& kind = editKinds()[std::size_t(i)];
        if (executes(kind.name) || kind.name.rfind(only, 0) == 0) {
            kinds.insert(kinds.end(), std::size_t(kind.weight), i);
        }
    }
    Random random(seed);
    std::vector<Step> steps;
    for (int i = 0; i < count; ++i) {
        const bool compares = i > 0 && (i + 1 == count || random.chance(0.12));
        const int kind = random.of(kinds);
        steps.push_back({i, compares ? -1 : kind, random.bits()});
    }
    return steps;
}

Outcome run(const std::vector<Step>& steps, Sabotage sabotage, const std::function<void(const std::string&)>& say,
            Clock::time_point end) {
    Session session(sabotage);
    Outcome outcome;
    for (std::size_t i = 0; i < steps.size() && Clock::now() < end; ++i) {
        const Step& step = steps[i];
        ++outcome.steps;
        if (step.kind < 0) {
            ++outcome.comparisons;
            outcome.difference = session.compare();
            say(std::to_string(step.number) + " compare");
            if (!outcome.difference.empty()) {
                outcome.failedStep = int(i);
                break;
            }
            continue;
        }
        const EditKind& kind = editKinds()[std::size_t(step.kind)];
        Random random(step.seed);
        const std::string said = kind.apply(session, random);
        if (!said.empty()) {
            ++outcome.applied[kind.name];
            outcome.edits += executes(kind.name) ? 0 : 1;
            say(std::to_string(step.number) + " " + kind.name + ": " + said);
        }
    }
    return outcome;
}

std::vector<Step> shorten(std::vector<Step> steps, Sabotage sabotage, Clock::time_point end) {
    const auto fails = [&](const std::vector<Step>& fewer) {
        const Outcome outcome = run(
            fewer, sabotage, [](const std::string&) {}, end);
        return outcome.failedStep && *outcome.failedStep + 1 == int(fewer.size());
    };
    // Without most comparisons first: each takes longer than many edits.
    std::vector<Step> quick;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        if (steps[i].kind >= 0 || i + 1 == steps.size()) {
            quick.push_back(steps[i]);
        }
    }
    if (fails(quick)) {
        steps = quick;
    }
    for (std::size_t part = steps.size() / 2; part > 0 && Clock::now() < end;) {
        bool shorter = false;
        for (std::size_t from = 0; from + 1 < steps.size() && Clock::now() < end;) {
            const std::size_t to = std::min(from + part, steps.size() - 1); // the comparison stays
            std::vector<Step> fewer(steps.begin(), steps.begin() + std::ptrdiff_t(from));
            fewer.insert(fewer.end(), steps.begin() + std::ptrdiff_t(to), steps.end());
            if (fails(fewer)) {
                steps = fewer;
                shorter = true;
            } else {
                from = to;
            }
        }
        if (part > 1) {
            part /= 2;
        } else if (!shorter) {
            break;
        }
    }
    return steps;
}

} // namespace fuzz
