// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/density_import.h"
#include "stfLib/optics/property_table.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/commands.h"
#include "tools/stf/terminal_progress.h"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace stf {

namespace {

struct Arguments {
    DensityImport import;
    std::string material, table, tile = "none", out;
    double voxel = 0;
    int overlap = 0;
    bool json = false;
};

void run(Arguments a) {
    const MessageSink messages = [](Severity severity, const std::string& text) {
        std::fprintf(stderr, "%s%s\n", severity == Severity::Info ? "" : "warning: ", text.c_str());
    };
    a.import.material = (a.table.empty() ? PropertyTable::builtIn() : PropertyTable::read(a.table)).find(a.material);
    if (a.voxel > 0) {
        a.import.voxelMm = a.voxel;
    }
    if (a.overlap > 0) {
        a.import.overlap = a.overlap;
    }
    a.import.tiling = a.tile == "blend"   ? ScanRecipe::Tiling::Blend
                      : a.tile == "quilt" ? ScanRecipe::Tiling::Quilt
                                          : ScanRecipe::Tiling::None;
    TerminalProgress progress(true);
    const ImportedDensity result = importDensity(a.import, progress, messages);
    const BaseVolume& v = result.scan.volume;
    writeBaseVolume(v, a.out);
    const Vec3d mm = v.extentMm();
    const double kept = result.tileIntegral / result.sourceIntegral;
    if (a.json) {
        std::printf("%s\n", nlohmann::json{{"path", a.out},
                                           {"grid", result.density.grid},
                                           {"material", a.import.material.name},
                                           {"size", {v.size.x, v.size.y, v.size.z}},
                                           {"extentMm", {mm.x, mm.y, mm.z}},
                                           {"densityMax", result.density.highest},
                                           {"sourceIntegralMm3", result.sourceIntegral},
                                           {"tileIntegralMm3", result.tileIntegral},
                                           {"periodicityError", {result.scan.after.x, result.scan.after.y}},
                                           {"hash", v.contentHash()}}
                                .dump()
                                .c_str());
        return;
    }
    std::printf("%s: %s of %s, %d x %d x %d voxels, %.3g x %.3g x %.3g mm\n", a.out.c_str(),
                result.density.grid.c_str(), a.import.material.name.c_str(), v.size.x, v.size.y, v.size.z, mm.x, mm.y,
                mm.z);
    std::printf("density up to %.4g; density times volume: %.4g %% of the file's%s\n", result.density.highest,
                100 * kept, a.tile == "quilt" ? " (a quilted tile is smaller)" : "");
    std::printf("sides: periodicity error %.2f along x, %.2f along y%s\n", result.scan.after.x, result.scan.after.y,
                a.tile == "none" ? " (--tile blend or quilt joins them)" : "");
}

} // namespace

void addImportCommand(CLI::App& app) {
    auto* command = app.add_subcommand("import", "Make a base volume of a density grid of another program");
    auto a = std::make_shared<Arguments>();
    command->add_option("density", a->import.path, "The OpenVDB file, of Blender, Houdini, EmberGen ...")->required();
    command->add_option("out", a->out, "The .vdb to write")->required();
    command->add_option("--material", a->material, "What the density is of, at 1 (stf materials)")->required();
    command->add_option("--table", a->table, "A table of materials of your own (docs/materials.md)");
    command->add_option("--density-scale", a->import.densityScale, "Factor on the density (1)")
        ->check(CLI::PositiveNumber);
    command->add_option("--grid", a->import.grid, "Name of the grid (density, or the only one of floats)");
    command->add_option("--mm-per-unit", a->import.mmPerUnit, "Millimetres to a unit of the file's world (1000)")
        ->check(CLI::PositiveNumber);
    command->add_option("--depth", a->import.depth, "Axis that goes into the material: +x -x +y -y +z -z (-z)");
    command->add_option("--voxel", a->voxel, "Resample to voxels of about this edge in mm (the file's own)")
        ->check(CLI::PositiveNumber);
    command->add_option("--tile", a->tile, "Make the sides fit: none, blend or quilt")
        ->check(CLI::IsMember({"none", "blend", "quilt"}));
    command->add_option("--overlap", a->overlap, "Voxels that joining the sides may use")->check(CLI::PositiveNumber);
    command->add_option("--max-memory", a->import.maxMemoryMB, "MB that may be used (4096)")
        ->check(CLI::PositiveNumber);
    command->add_flag("--json", a->json, "Print a line of JSON");
    command->callback([a] { run(*a); });
}

} // namespace stf
