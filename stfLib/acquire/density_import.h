// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_acquire.h"
#include "stfLib/acquire/scan_vdb.h"

namespace stf {

/// How a density becomes a medium: sigma = density * densityScale * sigma of the material, for absorption and
/// scattering; where the density is 0 nothing is.
struct DensityImport {
    std::string path, grid; ///< grid empty: "density", or the only float grid
    Material material;
    double densityScale = 1;
    double mmPerUnit = 1000;       ///< of the file's world: a metre, as Blender and Houdini take it
    std::string depth = "-z";      ///< axis of the world that goes into the material
    std::optional<double> voxelMm; ///< resampled to voxels of about this edge
    ScanRecipe::Tiling tiling = ScanRecipe::Tiling::None;
    std::optional<int> overlap; ///< voxels, of tiling
    double maxMemoryMB = 4096;
};

struct ImportedDensity {
    AcquiredScan scan;
    DensitySummary density;
    double sourceIntegral = 0; ///< density times volume, mm^3
    double tileIntegral = 0;   ///< the same of the tile
};

/// Makes a base volume of a density. Throws Error that names the file: unreadable, no such grid, a level set, negative
/// or not finite values, nothing but zeros, too large for the limit; Cancelled.
ImportedDensity importDensity(const DensityImport& options, Progress& progress, const MessageSink& messages = {});

} // namespace stf
