// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/raw_dump.h"
#include "tools/stf/table_json.h"
#include "tools/stf/volume_json.h"
#include "tools/stf/volume_sheet.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

void run(const std::string& path, const std::string& raw, const std::string& sheet, bool json) {
    const MessageSink messages = [](Severity, const std::string& t) { std::fprintf(stderr, "%s\n", t.c_str()); };
    if (!raw.empty()) {
        writeRaw(readBaseVolume(path, messages), raw);
        return;
    }
    nlohmann::json j;
    std::string reason;
    try {
        const BaseVolume volume = readBaseVolume(path, messages);
        const VolumeStatistics statistics = statisticsOf(volume);
        j = describeVolume(volume, statistics);
        if (!sheet.empty()) {
            writeVolumeSheet(volume, statistics, sheet);
        }
    } catch (const Error& e) {
        reason = e.what();
        try {
            j = describeTable(readTable(path, ""));
        } catch (const Error&) {
            throw Error(reason);
        }
    }
    if (json) {
        std::printf("%s\n", j.dump().c_str());
        return;
    }
    const nlohmann::json warnings = j.value("warnings", nlohmann::json::array());
    j.erase("warnings");
    for (const auto& [key, value] : j.items()) {
        std::printf("%-28s %s\n", key.c_str(), value.dump().c_str());
    }
    for (const auto& warning : warnings) {
        std::printf("warning: %s\n", warning.get<std::string>().c_str());
    }
}

} // namespace

void addInspectCommand(CLI::App& app) {
    auto* command = app.add_subcommand("inspect", "Print what a base volume or a table holds");
    struct Arguments {
        std::string path, raw, sheet;
        bool json = false;
    };
    auto a = std::make_shared<Arguments>();
    command->add_option("file", a->path, "Base volume or table (.vdb)")->required();
    command->add_option("--raw", a->raw,
                        "Write the volume into this folder instead: volume.json and a file of floats for each grid");
    command->add_option("--sheet", a->sheet, "Draw the volume into this PNG: cuts, slices, surface, histograms");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(a->path, a->raw, a->sheet, a->json); });
}

} // namespace stf
