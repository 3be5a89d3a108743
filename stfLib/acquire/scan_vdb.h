// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_reader.h"

namespace stf {

/// A float grid of an OpenVDB file as a scan: the box of its active voxels, the background around them. `grid` is its
/// name; empty: "density", or the only float grid. A unit of the file's world is a millimetre. Transforms that turn or
/// shear are resampled to voxels along the world's axes, as fine as the finest edge, with the same integral.
/// Throws Error: no such grid (tells which there are), nothing active, a perspective transform.
std::unique_ptr<ScanReader> openVdb(const std::string& path, const std::string& grid, const MessageSink& messages);

/// What a float grid holds, of its active voxels.
struct DensitySummary {
    std::string grid, gridClass; ///< "fog volume", "level set", "staggered", "unknown"
    Vec3i size{0, 0, 0};         ///< of the box of active voxels
    Vec3d voxel{1, 1, 1};        ///< edges in units of the world
    double lowest = 0, highest = 0;
    double integral = 0; ///< value times volume, in units of the world
    std::size_t active = 0;
};
/// Throws Error that names the file, and the first voxel that is not finite.
DensitySummary summarizeDensity(const std::string& path, const std::string& grid);

} // namespace stf
