// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/control_mesh_reader.h"
#include "tools/stf/synthesis_json.h"
#include "tools/stf/synthesis_sheet.h"
#include "tools/stf/terminal_progress.h"
#include "tools/stfrecord/atomicFile.h"

#include <cstdio>
#include <fstream>
#include <memory>

namespace stf {

namespace {

constexpr double kDefaultSamples = 300000;

struct Arguments {
    std::string mesh, volume, report, sheet, scheme = "none";
    double samples = 0, density = 1, mmPerUnit = 0, patch = 0;
    int seed = 0, threads = 0;
    double maxTriangles = 16e6;
    bool json = false;
};

void run(const Arguments& a) {
    setThreadCount(a.threads);
    const MessageSink messages = [](Severity, const std::string& t) { std::fprintf(stderr, "%s\n", t.c_str()); };
    const MessageSink ofMesh = [&](Severity s, const std::string& t) { messages(s, a.mesh + ": " + t); };
    const BaseVolume volume = readBaseVolume(a.volume, messages);
    RefinedSurface surface = readRefinedSurface(a.mesh, a.scheme, messages);
    try {
        const double texel = std::max(volume.voxelMm.x, volume.voxelMm.y);
        const double area = surfaceArea(surface);
        const double wanted = a.samples > 0 ? a.samples : kDefaultSamples;
        const double mmPerUnit =
            a.mmPerUnit > 0 ? a.mmPerUnit : std::sqrt(wanted / a.density * volume.voxelMm.x * volume.voxelMm.y / area);
        surface = sampleSurface(std::move(surface), texel / std::sqrt(a.density), mmPerUnit,
                                std::size_t(a.maxTriangles), ofMesh);
        SynthesisOptions options;
        options.seed = std::uint64_t(a.seed);
        options.patchMm = a.patch;
        Synthesis synthesis;
        {
            TerminalProgress progress(!a.json);
            synthesis = synthesize(surface, volume, mmPerUnit, options, progress);
        }
        const ExemplarMap map = exemplarMap(synthesis);
        const SynthesisQuality quality = measure(synthesis, map);
        const std::string json = synthesisJson(synthesis, quality);
        if (!a.report.empty()) {
            stfrecord::writeAtomically(a.report, [&](const std::string& temporary) {
                std::ofstream out(temporary);
                out << json << "\n";
                if (!out.flush()) {
                    throw Error(a.report + ": cannot be written");
                }
            });
        }
        if (!a.sheet.empty()) {
            writeSynthesisSheet(surface, synthesis, map, a.sheet);
        }
        std::fputs(a.json ? (json + "\n").c_str() : synthesisText(synthesis, quality).c_str(), stdout);
    } catch (const Error& e) {
        throw Error(a.mesh + ": " + e.what());
    }
}

} // namespace

void addSynthesizeCommand(CLI::App& app) {
    auto* command =
        app.add_subcommand("synthesize", "Grow a sample over a mesh and measure how well (docs/synthesis.md)");
    auto a = std::make_shared<Arguments>();
    command->add_option("mesh", a->mesh, "OBJ, PLY, STL, OFF or USD")->required();
    command->add_option("volume", a->volume, "Base volume (.vdb)")->required();
    command->add_option("--report", a->report, "Write the measures as JSON");
    command->add_option("--sheet", a->sheet, "Write a PNG with pictures of patches, coordinates and material");
    auto* samples =
        command->add_option("--samples", a->samples, "Scale the mesh so that it takes about that many samples")
            ->check(CLI::Range(100.0, 2e7));
    command->add_option("--mmPerUnit", a->mmPerUnit, "Millimetres of the sample per unit of the mesh")
        ->check(CLI::PositiveNumber)
        ->excludes(samples);
    command->add_option("--density", a->density, "Samples per texel")->check(CLI::Range(0.01, 16.0));
    command->add_option("--patch", a->patch, "Distance between the middles of patches, mm; 0: by the sample")
        ->check(CLI::NonNegativeNumber);
    command->add_option("--scheme", a->scheme, "Subdivision: none, loop, catmullClark")
        ->check(CLI::IsMember({"none", "loop", "catmullClark"}));
    command->add_option("--seed", a->seed, "Other patches");
    command->add_option("--maxTriangles", a->maxTriangles, "Of the sampled surface")->check(CLI::Range(1e3, 1e8));
    command->add_option("--threads", a->threads, "0: all cores; the result does not depend on it")
        ->check(CLI::Range(0, 4096));
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
