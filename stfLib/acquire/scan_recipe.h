// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_reader.h"
#include "stfLib/acquire/transfer_function.h"
#include "stfLib/optics/material.h"

#include <optional>
#include <string>
#include <vector>

namespace stf {

/// What `stf acquire scan` is asked for: docs/acquire_scan.md says what each field means. Paths are ready to be opened.
struct ScanRecipe {
    std::string input, name;
    ScanReadOptions read;
    std::optional<Vec3d> spacingMm;
    std::optional<double> nan;
    std::string crop, depth = "+z";
    double scale = 1;
    std::optional<Vec3d> voxelMm;

    enum class Method { Transfer, Thresholds, Otsu, Gmm } method = Method::Otsu;
    std::vector<Material> materials; ///< in order of brightness
    std::vector<TransferFunction::Point> points;
    std::vector<double> thresholds, widths;
    double gradientFlat = 0, gradientSteep = 0; ///< values per mm; steep 0: off

    enum class Tiling { None, Blend, Quilt } tiling = Tiling::None;
    std::optional<Vec3i> overlap; ///< voxels; z does not count

    enum class Surface { None, Auto, Value } surface = Surface::None;
    double iso = 0;
    double smooth = 1.3;
    std::optional<double> topMm; ///< absent: just above the material (without a surface: 0)
    bool topAuto = false;
    std::optional<Material> core; ///< absent: the mean of the tile's materials
    double maxMemoryMB = 4096;
};

/// Reads a recipe from the text of a JSON object; `patch`, another, replaces parts of it (RFC 7396). `origin` names the
/// recipe in messages, `folder` is where its relative paths start; those of the patch start where the program runs.
/// Throws Error that names the key: unknown, missing, of another type, out of range, unknown materials.
ScanRecipe parseScanRecipe(const std::string& text, const std::string& patch, const std::string& origin,
                           const std::string& folder);

} // namespace stf
