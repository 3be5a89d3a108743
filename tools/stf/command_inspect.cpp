// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/density_import.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/raw_dump.h"
#include "tools/stf/table_json.h"
#include "tools/stf/volume_json.h"
#include "tools/stf/volume_sheet.h"
#include "tools/stf/volume_usd.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

struct Arguments {
    std::string path, raw, sheet, usd;
    bool json = false;
};

void writeFiles(const BaseVolume& volume, const VolumeStatistics& statistics, const Arguments& a) {
    if (!a.sheet.empty()) {
        writeVolumeSheet(volume, statistics, a.sheet);
    }
    if (!a.usd.empty()) {
        writeVolumeUsd(volume, a.path, a.usd);
    }
}

// A density grid of another program; drawn as a grey medium of an extinction of the density per metre of its world.
nlohmann::json inspectDensity(const Arguments& a) {
    const DensitySummary s = summarizeDensity(a.path, "");
    if (!a.sheet.empty()) {
        DensityImport options;
        options.path = a.path;
        options.material.name = "grey";
        options.material.sigmaA = options.material.sigmaS = Vec3d(0.0005);
        Progress progress;
        const BaseVolume volume = importDensity(options, progress).scan.volume;
        writeVolumeSheet(volume, statisticsOf(volume), a.sheet);
    }
    const double volume = s.voxel.x * s.voxel.y * s.voxel.z * double(s.size.x) * s.size.y * s.size.z;
    return {{"kind", "density grid"},
            {"grid", s.grid},
            {"gridClass", s.gridClass},
            {"size", {s.size.x, s.size.y, s.size.z}},
            {"voxel", {s.voxel.x, s.voxel.y, s.voxel.z}},
            {"activeVoxels", s.active},
            {"lowest", s.lowest},
            {"highest", s.highest},
            {"mean", s.integral / volume},
            {"warnings",
             {"a density without a material: stf import " + a.path +
              " OUT.vdb --material NAME makes a base "
              "volume of it"}}};
}

// A base volume, a table, or a density of another program: each says what it is by its metadata.
nlohmann::json inspect(const Arguments& a, const MessageSink& messages) {
    std::string reason;
    try {
        const BaseVolume volume = readBaseVolume(a.path, messages);
        const VolumeStatistics statistics = statisticsOf(volume);
        writeFiles(volume, statistics, a);
        return describeVolume(volume, statistics);
    } catch (const Error& e) {
        reason = e.what();
    }
    try {
        return describeTable(readTable(a.path, ""));
    } catch (const Error&) {
        if (reason.find("stf:version") == std::string::npos) {
            throw Error(reason);
        }
    }
    try {
        return inspectDensity(a);
    } catch (const Error& e) {
        throw Error(reason + "; as a density: " + e.what());
    }
}

void run(const Arguments& a) {
    const MessageSink messages = [](Severity, const std::string& t) { std::fprintf(stderr, "%s\n", t.c_str()); };
    if (!a.raw.empty()) {
        writeRaw(readBaseVolume(a.path, messages), a.raw);
        return;
    }
    nlohmann::json j = inspect(a, messages);
    if (a.json) {
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
    auto* command = app.add_subcommand("inspect", "Print what a base volume, a table or a density grid holds");
    auto a = std::make_shared<Arguments>();
    command->add_option("file", a->path, "Base volume, table, or density of another program (.vdb)")->required();
    command->add_option("--raw", a->raw,
                        "Write the volume into this folder instead: volume.json and a file of floats for each grid");
    command->add_option("--sheet", a->sheet, "Draw the volume into this PNG: cuts, slices, surface, histograms");
    command->add_option("--usd", a->usd, "Write a scene (.usda) that shows the grids as a UsdVol Volume");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
