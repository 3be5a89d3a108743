// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

struct Arguments {
    std::string name, path;
    std::vector<int> size;
    std::vector<float> extinction{1, 1, 1}, albedo{0.9f, 0.9f, 0.9f};
    SampleOptions options;
    bool json = false;
};

Rgb rgb(const std::vector<float>& v) {
    return v.size() == 1 ? Rgb(v[0]) : Rgb(v[0], v[1], v[2]);
}

void run(const Arguments& a) {
    SampleOptions options = a.options;
    if (!a.size.empty()) {
        options.size = {a.size[0], a.size[1], a.size[2]};
    }
    options.extinction = rgb(a.extinction);
    options.albedo = rgb(a.albedo);
    const BaseVolume v = makeSample(a.name, options);
    writeBaseVolume(v, a.path);
    const Vec3d mm = v.extentMm();
    if (a.json) {
        std::printf("%s\n", nlohmann::json{{"path", a.path},
                                           {"name", v.name},
                                           {"size", {v.size.x, v.size.y, v.size.z}},
                                           {"extentMm", {mm.x, mm.y, mm.z}},
                                           {"hash", v.contentHash()}}
                                .dump()
                                .c_str());
    } else {
        std::printf("%s: %s, %d x %d x %d voxels, %.3g x %.3g x %.3g mm\n", a.path.c_str(), v.name.c_str(), v.size.x,
                    v.size.y, v.size.z, mm.x, mm.y, mm.z);
    }
}

} // namespace

void addMakeCommand(CLI::App& app) {
    auto* command = app.add_subcommand("make", "Write a modelled base volume");
    auto a = std::make_shared<Arguments>();
    std::string names;
    for (const SampleInfo& i : sampleNames()) {
        names += "\n    " + i.name + ": " + i.description;
    }
    command->add_option("name", a->name, "One of:" + names)->required();
    command->add_option("out", a->path, "The .vdb to write")->required();
    command->add_option("--size", a->size, "Voxels: X,Y,Z")->delimiter(',')->expected(3);
    command->add_option("--voxel", a->options.voxelMm, "Edge of a voxel in mm")->check(CLI::PositiveNumber);
    command->add_option("--seed", a->options.seed, "Another sample of the same kind");
    command->add_option("--extinction", a->extinction, "uniform: 1/mm, one number or R,G,B")
        ->delimiter(',')
        ->expected(1, 3);
    command->add_option("--albedo", a->albedo, "uniform, random: 0 to 1, one number or R,G,B")
        ->delimiter(',')
        ->expected(1, 3);
    command->add_option("--g", a->options.g, "uniform, random: mean cosine of the phase function");
    command->add_option("--ior", a->options.ior, "Index of refraction of all material, instead of the sample's own");
    command->add_option("--ratio", a->options.ratio, "random: largest extinction over smallest");
    command->add_option("--tau", a->options.tau, "random: mean optical depth from top to bottom");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] {
        if (a->extinction.size() == 2 || a->albedo.size() == 2) {
            throw CLI::ValidationError("--extinction and --albedo take one or three numbers");
        }
        run(*a);
    });
}

} // namespace stf
