// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/map_stf.h"
#include "tools/stf/map_walk.h"
#include "tools/stf/terminal_progress.h"

#include <cstdio>
#include <memory>

namespace stf {

void addMapCommand(CLI::App& app) {
    auto* command =
        app.add_subcommand("map", "A laboratory: the radiance that leaves a flat tile under parallel light");
    auto arguments = std::make_shared<MapArguments>();
    arguments->addTo(*command);
    command->callback([arguments] {
        const MapOptions options = arguments->parse();
        setThreadCount(options.threads);
        const BaseVolume volume = readBaseVolume(
            options.volume, [](Severity, const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); });
        MapResult result;
        {
            TerminalProgress progress(!arguments->json());
            result = options.method == MapOptions::Method::Stf ? mapByTable(volume, options, progress)
                                                               : mapByWalks(volume, options, progress);
        }
        if (!options.out.empty()) {
            writeMap(result, options.out);
        }
        std::fputs(arguments->json() ? (mapJson(options, result) + "\n").c_str() : mapText(options, result).c_str(),
                   stdout);
    });
}

} // namespace stf
