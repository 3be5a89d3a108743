// SPDX-License-Identifier: Apache-2.0
// Random edits of a stage, seen by a delegate that follows them and by one that is made anew (docs/testing.md).
#include "edits.h"
#include "fuzz_diagnostics.h"
#include "fuzz_run.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <iostream>

namespace {

using Clock = std::chrono::steady_clock;
using fuzz::Sabotage;

double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void printCover(const std::map<std::string, int>& applied) {
    std::cout << "edits of each kind:\n";
    for (const fuzz::EditKind& kind : fuzz::editKinds()) {
        const auto it = applied.find(kind.name);
        std::cout << "  " << (it == applied.end() ? 0 : it->second) << "\t" << kind.name << "\n";
    }
}

void printShortest(const std::vector<fuzz::Step>& steps, Sabotage sabotage, double seconds) {
    const Clock::time_point end = Clock::now() + std::chrono::milliseconds(int(1000 * seconds));
    const std::vector<fuzz::Step> few = fuzz::shorten(steps, sabotage, end);
    std::cout << "the shortest list of steps found:\n";
    const fuzz::Outcome last = fuzz::run(
        few, sabotage, [](const std::string& line) { std::cout << "  " << line << "\n"; },
        Clock::now() + std::chrono::minutes(1));
    std::cout << last.difference;
}

} // namespace

int main(int argc, char** argv) {
    std::uint64_t seed = 1;
    int steps = 1000, runs = 1;
    double seconds = 1e9, shortenSeconds = 60;
    bool verbose = false, expectMismatch = false;
    std::string only;
    Sabotage sabotage = Sabotage::None;
    const std::map<std::string, Sabotage> sabotages = {{"none", Sabotage::None},
                                                       {"dirtyBit", Sabotage::DirtyBit},
                                                       {"instancer", Sabotage::Instancer},
                                                       {"aov", Sabotage::Aov}};
    CLI::App app("Edits a stage at random and compares what a delegate makes of it with what a new one does.");
    app.add_option("--seed", seed, "of the first run")->capture_default_str();
    app.add_option("--steps", steps, "of each run")->capture_default_str()->check(CLI::Range(2, 1 << 24));
    app.add_option("--runs", runs, "each with the next seed and a new stage")->capture_default_str();
    app.add_option("--seconds", seconds, "ends after that time, whatever is left of the steps");
    app.add_option("--shorten", shortenSeconds, "seconds to look for the shortest list of steps")
        ->capture_default_str();
    app.add_option("--only", only, "edits whose name starts with this");
    app.add_option("--sabotage", sabotage, "a fault to put in: none, dirtyBit, instancer, aov")
        ->transform(CLI::CheckedTransformer(sabotages));
    app.add_flag("--expect-mismatch", expectMismatch, "succeeds where a comparison differs, fails otherwise");
    app.add_flag("--verbose", verbose, "prints each step");
    CLI11_PARSE(app, argc, argv);

    fuzz::Diagnostics diagnostics;
    const Clock::time_point start = Clock::now(), end = start + std::chrono::milliseconds(std::int64_t(1000 * seconds));
    std::map<std::string, int> applied;
    int edits = 0, comparisons = 0, done = 0;
    bool differs = false;
    for (; done < runs && Clock::now() < end && !differs; ++done) {
        const std::uint64_t runSeed = seed + std::uint64_t(done);
        const std::vector<fuzz::Step> all = fuzz::makeSteps(runSeed, steps, only);
        const fuzz::Outcome outcome = fuzz::run(
            all, sabotage, [&](const std::string& line) { verbose ? std::cout << line << std::endl : std::cout; }, end);
        edits += outcome.edits;
        comparisons += outcome.comparisons;
        for (const auto& [kind, count] : outcome.applied) {
            applied[kind] += count;
        }
        if (outcome.failedStep) {
            differs = true;
            std::cout << "MISMATCH: --seed " << runSeed << " --steps " << steps << (only.empty() ? "" : " --only ")
                      << only << ", at step " << *outcome.failedStep << "\n"
                      << outcome.difference << std::flush;
            if (shortenSeconds > 0) {
                printShortest({all.begin(), all.begin() + *outcome.failedStep + 1}, sabotage, shortenSeconds);
            }
        }
    }
    printCover(applied);
    std::cout << edits << " edits, " << comparisons << " comparisons, " << done << " stages, " << since(start)
              << " s\n";
    const bool clean = diagnostics.print();
    if (expectMismatch) {
        std::cout << (differs ? "the fault was found\n" : "THE FAULT WAS NOT FOUND\n");
        return differs ? 0 : 1;
    }
    return differs || !clean ? 1 : 0;
}
