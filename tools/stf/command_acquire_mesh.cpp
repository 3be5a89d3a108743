// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/mesh_acquisition_json.h"
#include "tools/stf/terminal_progress.h"
#if HDSTF_WITH_OPENUSD
#include "tools/stf/usd_mesh_reader.h"
#endif

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

namespace stf {

namespace {

using nlohmann::json;

struct Arguments {
    std::string out, recipe, matrix, core, top, relief, materials, name;
    std::vector<double> size, voxel;
    std::vector<std::string> meshes;
    double maxMemoryMb = 4096;
    int threads = 0;
    bool asJson = false, report = false;
};

std::string readText(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::stringstream text;
    if (!in || !(text << in.rdbuf())) {
        throw Error(path + ": cannot be read");
    }
    return text.str();
}

/// A mesh of the command line; its file is relative to the current folder, whatever the recipe is relative to.
json meshOf(const std::string& words) {
    json mesh = json::parse(meshWords(words));
    if (mesh.contains("file")) {
        mesh["file"] = std::filesystem::absolute(mesh["file"].get<std::string>()).string();
    }
    return mesh;
}

/// A material of the command line: a name, or written out as JSON.
json materialOf(const std::string& text) {
    if (text.empty() || text[0] != '{') {
        return text;
    }
    try {
        return json::parse(text);
    } catch (const json::exception& e) {
        throw Error("the material " + text + " is not JSON (" + e.what() + ")");
    }
}

MeshRecipe recipeOf(const Arguments& a) {
    json j = json::object();
    std::string origin = "command line", folder;
    if (!a.recipe.empty()) {
        origin = a.recipe;
        folder = std::filesystem::path(a.recipe).parent_path().string();
        try {
            j = json::parse(readText(a.recipe));
        } catch (const json::exception& e) {
            throw Error(a.recipe + ": is not JSON (" + e.what() + ")");
        }
        if (!j.is_object()) {
            throw Error(a.recipe + ": is not an object");
        }
    }
    const auto put = [&](const char* key, const std::string& value) {
        if (!value.empty()) {
            j[key] = value;
        }
    };
    put("name", a.name);
    put("top", a.top);
    if (!a.matrix.empty()) {
        j["matrix"] = materialOf(a.matrix);
    }
    if (!a.core.empty()) {
        j["core"] = materialOf(a.core);
    }
    if (!a.materials.empty()) {
        j["table"] = std::filesystem::absolute(a.materials).string();
    }
    if (!a.size.empty()) {
        j["size"] = a.size;
    }
    if (!a.voxel.empty()) {
        j["voxel"] = a.voxel.size() == 1 ? json(a.voxel[0]) : json(a.voxel);
    }
    if (!a.relief.empty()) {
        j["top"] = meshOf(a.relief);
    }
    for (const std::string& words : a.meshes) {
        j["meshes"].push_back(meshOf(words));
    }
    return parseMeshRecipe(j.dump(), origin, folder);
}

void print(const json& j, bool report) {
    const auto& size = j["size"];
    const auto& mm = j["extentMm"];
    std::printf("%s: %s, %d x %d x %d voxels, %.4g x %.4g x %.4g mm\n", j["path"].get<std::string>().c_str(),
                j["name"].get<std::string>().c_str(), size[0].get<int>(), size[1].get<int>(), size[2].get<int>(),
                mm[0].get<double>(), mm[1].get<double>(), mm[2].get<double>());
    for (const auto& [name, share] : j["shares"].items()) {
        std::printf("  %-24s %7.3f %% of the tile\n", name.c_str(), 100 * share.get<double>());
    }
    for (const auto& m : j["meshes"]) {
        if (report) {
            std::printf("  %s (%s): %s; x%zu, %.6g mm^3\n", m["mesh"].get<std::string>().c_str(),
                        m["material"].get<std::string>().c_str(), m["summary"].get<std::string>().c_str(),
                        m["copies"].get<std::size_t>(), m["volumeMm3"].get<double>());
        }
    }
}

void run(const Arguments& a) {
    const MeshRecipe recipe = recipeOf(a);
    setThreadCount(a.threads);
    const double maxBytes = a.maxMemoryMb * 1e6;
    const MessageSink messages = [](Severity, const std::string& t) { std::fprintf(stderr, "%s\n", t.c_str()); };
    const MeshReader reader = [&](const std::string& path) {
#if HDSTF_WITH_OPENUSD
        if (isUsdPath(path)) {
            return readUsdMeshes(path, messages);
        }
#endif
        return readMeshFile(path, maxBytes / 4);
    };
    MeshAcquisition result;
    {
        TerminalProgress progress(!a.asJson);
        result = acquireMesh(recipe, reader, maxBytes, progress, messages);
    }
    writeBaseVolume(result.volume, a.out);
    const json j = describeAcquisition(result, a.out);
    if (a.asJson) {
        std::printf("%s\n", j.dump().c_str());
    } else {
        print(j, a.report);
    }
}

} // namespace

void addAcquireMeshCommand(CLI::App& group) {
    auto* command = group.add_subcommand("mesh", "Scan-convert 3D models into a base volume (docs/acquire_mesh.md)");
    auto a = std::make_shared<Arguments>();
    command->add_option("out", a->out, "The .vdb to write")->required();
    command->add_option("--recipe", a->recipe, "What to make, as JSON; the options below replace what it says");
    command->add_option("--size", a->size, "Voxels: X,Y,Z")->delimiter(',')->expected(3);
    command->add_option("--voxel", a->voxel, "Edge of a voxel in mm, one number or X,Y,Z")
        ->delimiter(',')
        ->expected(1, 3);
    command->add_option("--matrix", a->matrix, "Material around the meshes: a name or JSON");
    command
        ->add_option(
            "--mesh", a->meshes,
            "FILE,material=NAME,priority=N,scale=..,rotate=X:Y:Z,translate=X:Y:Z,fit,part=..,body,surface,\n"
            "scatter.count=N,...; in place of FILE shape=sphere, box, cylinder, pebble or layer; may be repeated")
        ->take_all();
    command->add_option("--relief", a->relief, "FILE,fit,scale=..,...: its upper envelope is the tile's surface");
    command->add_option("--top", a->top, "flat, or geometry: that of the meshes marked body");
    command->add_option("--core", a->core, "Material below the tile; that of the matrix if not given");
    command->add_option("--table,--materials", a->materials, "A table of materials");
    command->add_option("--name", a->name, "Name of the volume");
    command->add_option("--max-memory", a->maxMemoryMb, "MB that may be taken")->check(CLI::PositiveNumber);
    command->add_option("--threads", a->threads, "0: all cores; the result does not depend on it")
        ->check(CLI::Range(0, 4096));
    command->add_flag("--report", a->report, "Print what was found and repaired in each mesh");
    command->add_flag("--json", a->asJson, "Print a line of JSON");
    command->callback([a] {
        if (a->voxel.size() == 2) {
            throw CLI::ValidationError("--voxel takes one or three numbers");
        }
        run(*a);
    });
}

} // namespace stf
