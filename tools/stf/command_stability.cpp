// SPDX-License-Identifier: Apache-2.0
#include "tools/stability/stability_case.h"
#include "tools/stf/commands.h"
#include "tools/stf/terminal_progress.h"

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdio>
#include <memory>

namespace stf {

namespace {

struct StabilityArguments {
    std::vector<std::string> only;
    bool quick = false, json = false, list = false;
};

nlohmann::ordered_json entry(const StabilityCase& c, const StabilityOutcome& o, double seconds) {
    return {{"id", c.id}, {"input", c.input},           {"mustHold", c.mustHold}, {"measured", o.measured},
            {"ok", o.ok}, {"knownLimit", c.knownLimit}, {"seconds", seconds}};
}

void printCase(const StabilityCase& c, const StabilityOutcome& o, double seconds) {
    std::printf("%-6s %-26s %s\n%33s must hold: %s\n%33s measured:  %s (%.1f s)\n",
                !o.ok          ? "FAILED"
                : c.knownLimit ? "limit"
                               : "ok",
                c.id.c_str(), c.input.c_str(), "", c.mustHold.c_str(), "", o.measured.c_str(), seconds);
    std::fflush(stdout);
}

int runCases(const StabilityArguments& a) {
    const std::vector<StabilityCase> cases = chooseStabilityCases(a.only, a.quick);
    if (a.list) {
        for (const StabilityCase& c : cases) {
            std::printf("%-26s %s\n", c.id.c_str(), c.input.c_str());
        }
        return kDone;
    }
    StabilityRun run;
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    int failed = 0, limits = 0;
    double total = 0;
    for (const StabilityCase& c : cases) {
        const auto start = std::chrono::steady_clock::now();
        const StabilityOutcome o = runStabilityCase(c, run);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        failed += o.ok ? 0 : 1;
        limits += o.ok && c.knownLimit ? 1 : 0;
        total += seconds;
        if (a.json) {
            list.push_back(entry(c, o, seconds));
        } else {
            printCase(c, o, seconds);
        }
    }
    if (a.json) {
        std::printf("%s\n", list.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    } else {
        std::printf("%d cases, %d failed, %d known limits, %.0f s\n", int(cases.size()), failed, limits, total);
    }
    return failed == 0 ? kDone : kChecksFailed;
}

} // namespace

void addStabilityCommand(CLI::App& app) {
    auto* command = app.add_subcommand("stability", "Stiff and extreme inputs, and whether what must hold holds");
    auto a = std::make_shared<StabilityArguments>();
    command->add_option("--only", a->only, "points (1 to 13, plan) or cases by id")->type_name("ID..");
    command->add_flag("--quick", a->quick, "without the slow cases");
    command->add_flag("--list", a->list, "list the cases and run none");
    command->add_flag("--json", a->json, "the result as JSON");
    command->callback([a] {
        if (const int code = runCases(*a)) {
            throw CLI::RuntimeError(code);
        }
    });
}

} // namespace stf
