// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_view.h"
#include "stfLib/acquire/tile_field.h"
#include "stfLib/acquire/transfer_function.h"
#include "stfLib/base/progress.h"

namespace stf {

/// How a voxel's materials follow from its value and, where wanted, from the gradient there.
struct ScanClassifier {
    TransferFunction transfer;
    std::vector<bool> isVoid; ///< of each material of the transfer function
    /// Gradient magnitudes in values per mm. Above `steep` a voxel is taken as a mixture of the materials at both ends
    /// of its edge (two voxels up and down the gradient; low and high values as in Serlie et al. 2003, "Computed
    /// cleansing for virtual colonoscopy"), not as the material whose value it happens to have on the way; below
    /// `flat` by its value alone; between, by both. steep = 0: by value everywhere.
    double flat = 0, steep = 0;

    int solidMaterials() const {
        int n = 0;
        for (const bool v : isVoid) {
            n += v ? 0 : 1;
        }
        return n;
    }
};

/// The level of a surface: |value - iso|, negative inside.
struct LevelRule {
    bool wanted = false;
    double iso = 0;
    bool insideAbove = true; ///< values above iso are inside
};

/// Classifies every voxel of a scan and resamples the fractions to `size` voxels of the same extent by box filtering:
/// the volume of every material is kept. Fractions at the scan's resolution are never held. The level is box-filtered
/// where voxels grow, linear where they shrink. Throws Cancelled.
TileField classifyScan(const ScanView& scan, const ScanClassifier& classifier, const LevelRule& level,
                       const Vec3i& size, Progress& progress);

} // namespace stf
