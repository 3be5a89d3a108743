// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/synthesis/choose_mapping.h"
#include "stfLib/synthesis/synthesize.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/control_mesh_reader.h"
#include "tools/stf/shell_json.h"
#include "tools/stf/terminal_progress.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <sys/resource.h>

namespace stf {

namespace {

constexpr std::size_t kMostTriangles = 16'000'000;

struct Arguments {
    std::string mesh, volume, vdb, scheme = "none", mapping = "auto";
    double thickness = 0, mmPerUnit = 0, samples = 300000, voxel = 0, error = 0.1, seam = 0.3, memory = 4096;
    int levels = 0, seed = 0, threads = 0;
    bool json = false;
};

double peakBytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
#ifdef __APPLE__
    return double(usage.ru_maxrss);
#else
    return double(usage.ru_maxrss) * 1024;
#endif
}

class Stages {
public:
    explicit Stages(ShellRun& run) : run_(run) {}
    void done(const char* stage) {
        const auto now = std::chrono::steady_clock::now();
        run_.seconds.emplace_back(stage, std::chrono::duration<double>(now - last_).count());
        last_ = now;
    }

private:
    ShellRun& run_;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

Mapping mappingOf(const Arguments& a, const RefinedSurface& surface, const BaseVolume& volume) {
    return a.mapping == "anywhere" ? Mapping::Anywhere : chooseMapping(a.mapping, surface, volume).mapping;
}

void run(const Arguments& a) {
    setThreadCount(a.threads);
    const MessageSink messages = [](Severity, const std::string& t) { std::fprintf(stderr, "%s\n", t.c_str()); };
    const MessageSink ofMesh = [&](Severity s, const std::string& t) { messages(s, a.mesh + ": " + t); };
    const BaseVolume volume = readBaseVolume(a.volume, messages);
    ShellRun run;
    Stages stages(run);
    RefinedSurface surface = readRefinedSurface(a.mesh, a.scheme, messages);
    try {
        const Vec3d extent = volume.extentMm();
        const double texel = std::min(volume.voxelMm.x, volume.voxelMm.y);
        run.mmPerUnit = a.mmPerUnit > 0
                            ? a.mmPerUnit
                            : std::sqrt(a.samples * volume.voxelMm.x * volume.voxelMm.y / surfaceArea(surface));
        stages.done("surface");

        TerminalProgress progress(!a.json);
        ExemplarMap map;
        const Mapping mapping = mappingOf(a, surface, volume);
        if (mapping == Mapping::Synthesize) {
            surface = sampleSurface(std::move(surface), std::max(volume.voxelMm.x, volume.voxelMm.y), run.mmPerUnit,
                                    kMostTriangles, ofMesh);
            SynthesisOptions options;
            options.seed = std::uint64_t(a.seed);
            map = exemplarMap(synthesize(surface, volume, run.mmPerUnit, options, progress));
        } else {
            map = mapAnywhere(surface, {extent.x, extent.y}, 1 / run.mmPerUnit);
        }
        run.mapping = map.description;
        run.triangles = surface.triangles.size();
        stages.done("mapping");

        run.thickness = float(a.thickness > 0 ? a.thickness : extent.z / run.mmPerUnit);
        const ShellBoundary boundary = offsetInward(surface, run.thickness, ofMesh);
        stages.done("boundary");

        ShellGridOptions options;
        options.mmPerUnit = run.mmPerUnit;
        options.voxelSize = float(a.voxel);
        options.levels = a.levels;
        options.texelMm = texel;
        options.errorTexels = a.error;
        options.seamTexels = a.seam;
        options.maxBytes = std::size_t(a.memory * 1048576);
        const ShellGrid grid = ShellGrid::build(surface, boundary, map, options, progress, ofMesh);
        stages.done("grid");
        if (!a.vdb.empty()) {
            grid.write(a.vdb);
            stages.done("write");
        }
        run.peakBytes = peakBytes();
        std::fputs(a.json ? (shellJson(grid, boundary, run) + "\n").c_str() : shellText(grid, boundary, run).c_str(),
                   stdout);
    } catch (const Error& e) {
        throw Error(a.mesh + ": " + e.what());
    }
}

} // namespace

void addShellCommand(CLI::App& app) {
    auto* command =
        app.add_subcommand("shell", "Build the shell grid of a mesh and measure its errors (docs/shell.md)");
    auto a = std::make_shared<Arguments>();
    command->add_option("mesh", a->mesh, "OBJ, PLY, STL, OFF or USD")->required();
    command->add_option("volume", a->volume, "Base volume (.vdb)")->required();
    command->add_option("--thickness", a->thickness, "Units of the mesh; 0: the sample's depth")
        ->check(CLI::NonNegativeNumber);
    auto* samples = command->add_option("--samples", a->samples, "Scale the mesh so that it has about that many texels")
                        ->check(CLI::Range(100.0, 2e7));
    command->add_option("--mmPerUnit", a->mmPerUnit, "Millimetres of the sample per unit of the mesh")
        ->check(CLI::PositiveNumber)
        ->excludes(samples);
    command->add_option("--mapping", a->mapping, "auto, synthesize, or anywhere: coordinates that do not continue")
        ->check(CLI::IsMember({"auto", "synthesize", "anywhere"}));
    command->add_option("--voxel", a->voxel, "Of the finest level, units of the mesh; 0: by the errors")
        ->check(CLI::NonNegativeNumber);
    command->add_option("--error", a->error, "Wanted rms error, texels")->check(CLI::PositiveNumber);
    command->add_option("--seam", a->seam, "Wanted mean displacement of seams, texels; 0: any")
        ->check(CLI::NonNegativeNumber);
    command->add_option("--levels", a->levels, "At most so many; 0: until voxels are as large as the shell is thick")
        ->check(CLI::Range(0, 12));
    command->add_option("--memory", a->memory, "MB that the grid may take")->check(CLI::Range(1.0, 1e7));
    command->add_option("--scheme", a->scheme, "Subdivision: none, loop, catmullClark")
        ->check(CLI::IsMember({"none", "loop", "catmullClark"}));
    command->add_option("--seed", a->seed, "Other patches");
    command->add_option("--threads", a->threads, "0: all cores; the result does not depend on it")
        ->check(CLI::Range(0, 4096));
    command->add_option("--vdb", a->vdb, "Write coordinate, depth, normal and triangle of the finest level");
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
