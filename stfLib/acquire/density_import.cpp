// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/density_import.h"

#include <cmath>
#include <filesystem>
#include <sstream>

namespace stf {

namespace {

void check(const DensityImport& o) {
    if (!(o.densityScale > 0) || !std::isfinite(o.densityScale)) {
        throw Error("the density scale must be positive and finite");
    }
    if (!(o.mmPerUnit > 0) || !std::isfinite(o.mmPerUnit)) {
        throw Error("the length of a unit must be positive and finite");
    }
    if (o.material.isVoid()) {
        throw Error("a density of a void is nothing: choose a material that scatters or absorbs");
    }
}

void check(const DensityImport& o, const DensitySummary& s) {
    const auto fail = [&](const std::string& text) { throw Error(o.path + ": grid '" + s.grid + "' " + text); };
    if (s.gridClass == "level set") {
        fail("is a level set, not a density (stf acquire scan with --iso takes surfaces)");
    }
    if (s.lowest < 0) {
        std::ostringstream text;
        text << "holds negative values, down to " << s.lowest << ": no density";
        fail(text.str());
    }
    if (!(s.highest > 0)) {
        fail("is zero everywhere");
    }
}

// The material at the highest density; voxels hold it by their share of that density.
Material densest(const DensityImport& o, double highest) {
    Material m = o.material;
    m.sigmaA = m.sigmaA * (o.densityScale * highest);
    m.sigmaS = m.sigmaS * (o.densityScale * highest);
    return m;
}

} // namespace

ImportedDensity importDensity(const DensityImport& o, Progress& progress, const MessageSink& messages) {
    check(o);
    ImportedDensity result;
    result.density = summarizeDensity(o.path, o.grid);
    check(o, result.density);

    ScanRecipe r;
    r.input = o.path;
    r.name = std::filesystem::path(o.path).stem().string();
    r.read.grid = result.density.grid;
    r.depth = o.depth;
    r.scale = o.mmPerUnit;
    if (o.voxelMm) {
        r.voxelMm = Vec3d(*o.voxelMm);
    }
    r.method = ScanRecipe::Method::Transfer;
    Material nothing;
    nothing.name = "none";
    r.materials = {nothing, densest(o, result.density.highest)};
    r.points = {{0, {1, 0}}, {result.density.highest, {0, 1}}};
    r.tiling = o.tiling;
    if (o.overlap) {
        r.overlap = Vec3i(*o.overlap, *o.overlap, 0);
    }
    r.maxMemoryMB = o.maxMemoryMB;
    result.scan = acquireScan(r, progress, messages);

    const BaseVolume& v = result.scan.volume;
    const Vec3d mm = v.extentMm();
    result.sourceIntegral = result.density.integral * o.mmPerUnit * o.mmPerUnit * o.mmPerUnit;
    result.tileIntegral = result.scan.tileFractions.back() * result.density.highest * mm.x * mm.y * mm.z;
    return result;
}

} // namespace stf
