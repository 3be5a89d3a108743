// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/raw_dump.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

void writeFile(const std::filesystem::path& path, const void* data, std::size_t bytes) {
    std::ofstream out(path, std::ios::binary);
    out.write(static_cast<const char*>(data), std::streamsize(bytes));
    out.close();
    if (!out) {
        throw Error("cannot write " + path.string());
    }
}

} // namespace

void writeRaw(const BaseVolume& v, const std::string& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
        throw Error("cannot make " + folder + ": " + error.message());
    }
    nlohmann::json grids = nlohmann::json::object();
    const auto add = [&](const char* name, const auto& values, int channels) {
        if (!values.empty()) {
            const std::string file = std::string(name) + ".f32";
            writeFile(std::filesystem::path(folder) / file, values.data(), values.size() * sizeof values[0]);
            grids[name] = {{"file", file}, {"channels", channels}};
        }
    };
    static_assert(sizeof(Rgb) == 3 * sizeof(float), "colours are written as they lie in memory");
    add("extinction", v.extinction, 3);
    add("albedo", v.albedo, 3);
    add("g", v.g, 1);
    add("ior", v.ior, 1);
    add("surface", v.surface, 1);
    add("emission", v.emission, 3);
    const nlohmann::json header{{"name", v.name},
                                {"size", {v.size.x, v.size.y, v.size.z}},
                                {"voxelMm", {v.voxelMm.x, v.voxelMm.y, v.voxelMm.z}},
                                {"hash", v.contentHash()},
                                {"grids", grids}};
    const std::string text = header.dump(1) + "\n";
    writeFile(std::filesystem::path(folder) / "volume.json", text.data(), text.size());
}

} // namespace stf
