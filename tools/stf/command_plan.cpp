// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/temporary_folder.h"
#include "tools/stf/commands.h"
#include "tools/stf/program_folder.h"
#include "tools/stf/run_program.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

namespace stf {

namespace {

using Json = nlohmann::ordered_json;

struct PlanArguments {
    std::string scene, camera;
    std::vector<std::string> settings;
    bool json = false, run = false;
};

/// The recorder's exit code.
int runRecorder(const std::vector<std::string>& words) {
    try {
        return runProgram(words).code;
    } catch (const Error& e) {
        throw Error(std::string(e.what()) + ": `stf plan` needs a build with OpenUSD");
    }
}

Json readPlan(const std::string& path) {
    std::ifstream file(path);
    const Json stats = Json::parse(file, nullptr, false);
    return stats.is_object() && stats.contains("plan") ? stats["plan"] : Json();
}

// The recorder looks at the scene as it does for a picture; told to plan only, the delegate then says what it would do.
Json planOf(const PlanArguments& a, bool only) {
    const TemporaryFolder folder;
    std::vector<std::string> words = {programBeside("stfrecord"), a.scene,  folder.file("plan.exr"), "--stats",
                                      folder.file("stats.json"),  "--quiet"};
    if (only) {
        words.insert(words.end(), {"--imageWidth", "16"});
        ::setenv("HDSTF_PLAN_ONLY", "1", 1);
    } else {
        ::unsetenv("HDSTF_PLAN_ONLY");
    }
    if (!a.camera.empty()) {
        words.insert(words.end(), {"--camera", a.camera});
    }
    for (const std::string& s : a.settings) {
        words.insert(words.end(), {"--set", s});
    }
    const int code = runRecorder(words);
    const Json plan = code == 0 || code == 1 ? readPlan(folder.file("stats.json")) : Json();
    if (!plan.is_array()) {
        throw Error("no plan of " + a.scene);
    }
    return plan;
}

/// Both plans in one: of what was foreseen and what it then cost.
Json merged(const Json& before, const Json& after) {
    Json all = Json::array();
    for (const Json& real : after) {
        Json entry = real;
        entry["estimatedSeconds"] = nullptr;
        for (const Json& f : before) {
            if (f["object"] == real["object"] && f["stage"] == real["stage"]) {
                entry["estimatedSeconds"] = f["estimatedSeconds"];
            }
        }
        all.push_back(entry);
    }
    return all;
}

std::string seconds(const Json& entry, const char* key) {
    char text[32] = "-";
    if (entry.contains(key) && entry[key].is_number()) {
        std::snprintf(text, sizeof text, "%.2f", entry[key].get<double>());
    }
    return text;
}

void printPlan(const Json& plan) {
    std::printf("%-32s %-14s %-5s %9s %9s  %s\n", "object", "stage", "runs", "estimate", "seconds", "why");
    for (const Json& e : plan) {
        std::printf("%-32s %-14s %-5s %9s %9s  %s\n", e.value("object", "").c_str(), e.value("stage", "").c_str(),
                    e.value("runs", false) ? "yes" : "no", seconds(e, "estimatedSeconds").c_str(),
                    seconds(e, "seconds").c_str(), e.value("why", "").c_str());
    }
}

} // namespace

void addPlanCommand(CLI::App& app) {
    auto* command = app.add_subcommand("plan", "What rendering a scene would do, why, and how long it takes");
    auto a = std::make_shared<PlanArguments>();
    command->add_option("SCENE", a->scene, "USD file")->required();
    command->add_option("--camera", a->camera, "path or name of a camera (default: the scene's first)");
    command->add_option("--set", a->settings, "KEY=VALUE, a render setting; may be repeated")->allow_extra_args(false);
    command->add_flag("--run", a->run, "render it too, and tell what each stage took");
    command->add_flag("--json", a->json, "the plan as JSON");
    command->callback([a] {
        Json plan = planOf(*a, true);
        if (a->run) {
            plan = merged(plan, planOf(*a, false));
        }
        if (a->json) {
            std::printf("%s\n", plan.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
        } else {
            printPlan(plan);
        }
    });
}

} // namespace stf
