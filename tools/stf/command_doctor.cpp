// SPDX-License-Identifier: Apache-2.0
#include "tools/doctor/environment_checks.h"
#include "tools/doctor/machine_checks.h"
#include "tools/doctor/plugin_checks.h"
#include "tools/doctor/render_check.h"
#include "tools/stf/commands.h"
#include "tools/stf/program_folder.h"

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

using doctor::Finding;
using doctor::Findings;

struct Arguments {
    std::string plugin, openUsd;
    bool json = false, noRender = false;
};

const char* word(Finding::State state) {
    static const char* const words[] = {"ok", "warning", "problem"};
    return words[int(state)];
}

void append(Findings& all, const Findings& more) {
    all.insert(all.end(), more.begin(), more.end());
}

Findings examine(const Arguments& a) {
    doctor::PluginSearch search;
    if (!a.plugin.empty()) {
        search.path = a.plugin;
    } else if (const char* const path = std::getenv("PXR_PLUGINPATH_NAME")) {
        search.path = path;
    }
    search.ownFolder = (programFolder() / "../plugin").lexically_normal().string();
    search.hostLibrary = a.openUsd;
    search.probe = programBeside("stf-probe");
    Findings all = doctor::checkPlugin(search);
    append(all, doctor::checkDenoiser());
    append(all, doctor::checkCache());
    append(all, doctor::checkMachine());
    append(all, doctor::checkEnvironment(doctor::environmentVariables()));
    if (!a.noRender) {
        append(all, doctor::checkRender((programFolder() / "stfrecord").string()));
    }
    return all;
}

void print(const Findings& findings) {
    for (const Finding& f : findings) {
        std::printf("%-8s %s: %s%s%s\n", word(f.state), f.topic.c_str(), f.text.c_str(), f.todo.empty() ? "" : " -> ",
                    f.todo.c_str());
    }
}

void printJson(const Findings& findings, std::size_t problems) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Finding& f : findings) {
        list.push_back({{"state", word(f.state)}, {"topic", f.topic}, {"text", f.text}, {"todo", f.todo}});
    }
    const nlohmann::ordered_json all{{"problems", problems}, {"findings", list}};
    std::printf("%s\n", all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

void run(const Arguments& a) {
    const Findings findings = examine(a);
    std::size_t problems = 0;
    for (const Finding& f : findings) {
        problems += f.state == Finding::State::Problem;
    }
    a.json ? printJson(findings, problems) : print(findings);
    if (problems > 0) {
        throw CLI::RuntimeError(kChecksFailed);
    }
}

} // namespace

void addDoctorCommand(CLI::App& app) {
    auto* command =
        app.add_subcommand("doctor", "Tell what keeps a host from showing the renderer Stf, or works badly");
    auto a = std::make_shared<Arguments>();
    command->add_option("--plugin", a->plugin, "Look there (default: what PXR_PLUGINPATH_NAME says)");
    command->add_option("--openusd", a->openUsd,
                        "A host's library of OpenUSD, to try the plugin with (libusd_ms.so, libhd.so)");
    command->add_flag("--no-render", a->noRender, "Render nothing");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
