// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/raw_dump.h"
#include "tools/stf/table_json.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

nlohmann::json triple(const Vec3d& v) {
    return {v.x, v.y, v.z};
}

nlohmann::json describe(const BaseVolume& v) {
    Vec3d lowest(1e300), highest(0.0), depth(0.0), albedo(0.0);
    std::size_t filled = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const Vec3d k(v.extinction[i]);
        for (int c = 0; c < 3; ++c) {
            lowest[c] = std::min(lowest[c], k[c]);
            highest[c] = std::max(highest[c], k[c]);
        }
        depth += k * v.voxelMm.z;
        if (maxComponent(v.extinction[i]) > 0) {
            albedo += Vec3d(v.albedo[i]);
            ++filled;
        }
    }
    const double columns = double(v.size.x) * v.size.y;
    return {{"kind", "base volume"},
            {"name", v.name},
            {"size", {v.size.x, v.size.y, v.size.z}},
            {"voxelMm", triple(v.voxelMm)},
            {"extentMm", triple(v.extentMm())},
            {"extinctionMin", triple(lowest)},
            {"extinctionMax", triple(highest)},
            {"meanOpticalDepth", triple(depth / columns)},
            {"meanAlbedo", triple(filled ? albedo / double(filled) : albedo)},
            {"filledShare", double(filled) / double(v.voxelCount())},
            {"coreSigmaA", triple(v.coreSigmaA)},
            {"coreSigmaSPrime", triple(v.coreSigmaSPrime)},
            {"laterallyUniform", v.laterallyUniform()},
            {"relief", v.hasRelief()},
            {"hash", v.contentHash()}};
}

void run(const std::string& path, const std::string& raw, bool json) {
    const MessageSink messages = [](Severity, const std::string& t) { std::fprintf(stderr, "%s\n", t.c_str()); };
    if (!raw.empty()) {
        writeRaw(readBaseVolume(path, messages), raw);
        return;
    }
    nlohmann::json j;
    std::string reason;
    try {
        j = describe(readBaseVolume(path, messages));
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
    for (const auto& [key, value] : j.items()) {
        std::printf("%-18s %s\n", key.c_str(), value.dump().c_str());
    }
}

} // namespace

void addInspectCommand(CLI::App& app) {
    auto* command = app.add_subcommand("inspect", "Print what a base volume or a table holds");
    struct Arguments {
        std::string path, raw;
        bool json = false;
    };
    auto a = std::make_shared<Arguments>();
    command->add_option("file", a->path, "Base volume or table (.vdb)")->required();
    command->add_option("--raw", a->raw,
                        "Write the volume into this folder instead: volume.json and a file of floats for each grid");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(a->path, a->raw, a->json); });
}

} // namespace stf
