// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/periodicity.h"
#include "stfLib/acquire/scan_recipe.h"
#include "stfLib/base/progress.h"
#include "stfLib/volume/base_volume.h"

#include <optional>

namespace stf {

/// A volume and what was found on the way to it.
struct AcquiredScan {
    BaseVolume volume;

    ScanHeader header;
    VoxelBox crop;            ///< voxels of the scan that were read
    Vec3d spacingMm{1, 1, 1}; ///< of the scan, before scaling
    double lowest = 0, highest = 0;
    std::size_t replaced = 0; ///< voxels that were not finite

    std::vector<ValueClass> classes;                ///< of Otsu or a mixture
    std::vector<TransferFunction::Point> transfer;  ///< what was classified by
    std::vector<std::string> materials;             ///< of the recipe, in its order
    std::vector<double> scanFractions;              ///< of materials in the scan's part, by volume
    std::vector<double> tileFractions;              ///< in the tile
    Vec3d scanSigmaA{0, 0, 0}, scanSigmaS{0, 0, 0}; ///< means over the scan's part, 1/mm
    Vec3d tileSigmaA{0, 0, 0}, tileSigmaS{0, 0, 0}; ///< means over the tile's fractions
    int firstLayer = 0;                             ///< of the scan's part that is the tile's first
    Vec3i overlap{0, 0, 0};                         ///< voxels
    PeriodicityError before, after;                 ///< of the sides
    std::optional<PeriodicityError> cut;            ///< across the cuts of quilting
    std::optional<double> iso;                      ///< of the surface
    double insideShare = 1;                         ///< of the tile's volume, by the surface
    double memoryBytes = 0;                         ///< at most, as computed beforehand
};

/// Reads, classifies, resamples, tiles and blends a scan. What this takes of memory is computed from the header and
/// compared with the limit before voxels are read. Throws Error that names the file; Cancelled.
AcquiredScan acquireScan(const ScanRecipe& recipe, Progress& progress, const MessageSink& messages = {});

} // namespace stf
