// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/scan_arguments.h"
#include "tools/stf/scan_json.h"
#include "tools/stf/terminal_progress.h"

#include <chrono>
#include <cstdio>
#include <memory>

namespace stf {

namespace {

void run(const ScanArguments& a) {
    const auto start = std::chrono::steady_clock::now();
    const MessageSink messages = [](Severity severity, const std::string& text) {
        std::fprintf(stderr, "%s%s\n", severity == Severity::Info ? "" : "warning: ", text.c_str());
    };
    const ScanRecipe recipe = a.recipe();
    TerminalProgress progress(true);
    setThreadCount(a.threads());
    const AcquiredScan scan = acquireScan(recipe, progress, messages);
    writeBaseVolume(scan.volume, a.out());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("%s\n",
                (a.json() ? scanJson(recipe, scan, a.out(), seconds) : scanText(scan, a.out(), seconds)).c_str());
}

} // namespace

void addAcquireScanCommand(CLI::App& group) {
    auto* command = group.add_subcommand("scan", "Make a base volume from a scan (docs/acquire_scan.md)");
    auto a = std::make_shared<ScanArguments>();
    a->addTo(*command);
    command->callback([a] { run(*a); });
}

} // namespace stf
