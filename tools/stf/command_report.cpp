// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/error.h"
#include "tools/stf/commands.h"
#include "tools/stf/program_folder.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <unistd.h>

namespace stf {

namespace {

std::string python() {
    const char* given = std::getenv("HDSTF_PYTHON");
    return given && *given ? given : "python3";
}

// The report is a program in Python: plots, FLIP and pages are libraries' work. It takes this process's place, so that
// an interrupt reaches it and nobody else.
void becomeReport(const std::vector<std::string>& given) {
    const auto script = programFolder() / "../share/hdstf/report/report.py";
    std::error_code error;
    if (!std::filesystem::exists(script, error)) {
        throw Error("`stf report` is not installed: there is no " + script.lexically_normal().string());
    }
    std::vector<std::string> words = {python(), script.lexically_normal().string(), "--stfrecord",
                                      programBeside("stfrecord")};
    words.insert(words.end(), given.begin(), given.end());
    std::vector<char*> argv;
    for (std::string& w : words) {
        argv.push_back(w.data());
    }
    argv.push_back(nullptr);
    std::fflush(nullptr);
    ::execvp(argv[0], argv.data());
    throw Error("cannot start " + words[0] + " (" + std::strerror(errno) +
                "): `stf report` needs Python 3.9 or later; HDSTF_PYTHON names another one");
}

} // namespace

void addReportCommand(CLI::App& app) {
    auto* command = app.add_subcommand("report", "Error of a scene's image against run time, on one page");
    command->set_help_flag(); // it tells its options itself
    command->prefix_command();
    command->callback([command] { becomeReport(command->remaining()); });
}

} // namespace stf
