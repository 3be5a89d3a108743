// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_reader.h"
#include "stfLib/acquire/mesh_repair.h"
#include "stfLib/base/parallel.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/synthesis_json.h"
#include "tools/stf/synthesis_sheet.h"
#include "tools/stf/terminal_progress.h"
#include "tools/stfrecord/atomicFile.h"
#if HDSTF_WITH_OPENUSD
#include "tools/stf/usd_mesh_reader.h"
#endif

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

/// All parts as one; triangles turned against their neighbours are turned back, for a surface has one outside.
ControlMesh controlMesh(const std::vector<MeshPart>& parts, const std::string& scheme, const std::string& name,
                        const MessageSink& messages) {
    TriangleMesh whole;
    for (const MeshPart& part : parts) {
        append(whole, part.mesh);
    }
    const MendedMesh mended = repair(whole, name);
    const MeshRepair& r = mended.repair;
    if (r.turned + r.degenerate + r.duplicates + r.crowdedEdges > 0) {
        messages(Severity::Warning, r.summary());
    }
    ControlMesh mesh;
    mesh.scheme = scheme == "loop"           ? ControlMesh::Scheme::Loop
                  : scheme == "catmullClark" ? ControlMesh::Scheme::CatmullClark
                                             : ControlMesh::Scheme::None;
    for (const Vec3d& p : mended.mesh.points) {
        mesh.points.push_back(Vec3f(p));
    }
    for (const Vec3i& t : mended.mesh.triangles) {
        mesh.faceVertexCounts.push_back(3);
        mesh.faceVertexIndices.insert(mesh.faceVertexIndices.end(), {t.x, t.y, t.z});
    }
    return mesh;
}

double areaOf(const RefinedSurface& s) {
    double sum = 0;
    for (const Vec3i& t : s.triangles) {
        const Vec3d p(s.points[std::size_t(t.x)]);
        sum += 0.5 * length(cross(Vec3d(s.points[std::size_t(t.y)]) - p, Vec3d(s.points[std::size_t(t.z)]) - p));
    }
    return sum;
}

void run(const Arguments& a) {
    setThreadCount(a.threads);
    const MessageSink messages = [](Severity, const std::string& t) { std::fprintf(stderr, "%s\n", t.c_str()); };
    const MessageSink ofMesh = [&](Severity s, const std::string& t) { messages(s, a.mesh + ": " + t); };
    const BaseVolume volume = readBaseVolume(a.volume, messages);
#if HDSTF_WITH_OPENUSD
    const std::vector<MeshPart> parts = isUsdPath(a.mesh) ? readUsdMeshes(a.mesh, messages) : readMeshFile(a.mesh);
#else
    const std::vector<MeshPart> parts = readMeshFile(a.mesh);
#endif
    try {
        ControlMesh mesh = controlMesh(parts, a.scheme, a.mesh, ofMesh);
        const std::string repairs = sanitize(mesh).summary();
        if (!repairs.empty()) {
            ofMesh(Severity::Warning, repairs);
        }
        RefineOptions refineOptions;
        Box3f box;
        for (const Vec3f& p : mesh.points) {
            box.add(p);
        }
        if (mesh.scheme != ControlMesh::Scheme::None) {
            refineOptions.targetEdge = box.diagonal() / 150;
        }
        RefinedSurface surface = refine(mesh, refineOptions, ofMesh);
        const double texel = std::max(volume.voxelMm.x, volume.voxelMm.y);
        const double area = areaOf(surface);
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
        throw Error(std::string(e.what()).rfind(a.mesh, 0) == 0 ? e.what() : a.mesh + ": " + e.what());
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
