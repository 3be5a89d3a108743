// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"

#include <vector>

namespace stf {

/// How much two pictures differ in the region where they overlap: `overlap` steps across it, `length` along it (which
/// may be a circle), `layers` deep.
struct OverlapCost {
    int overlap = 0, length = 0, layers = 0;
    bool circle = false;
    std::vector<float> difference; ///< [layer][along][across], >= 0

    std::size_t index(int across, int along, int layer) const {
        return std::size_t(across) +
               std::size_t(overlap) * (std::size_t(along) + std::size_t(length) * std::size_t(layer));
    }
};

/// Where one picture gives way to the other: at (along, layer) voxels [0, cut) are of the first, others of the second.
struct CutSurface {
    std::vector<int> cut; ///< [layer][along], 1 to overlap - 1
    double cost = 0;      ///< sum over faces between the pictures of the differences on both sides
    double faces = 0;     ///< how many faces there are
};

/// A surface through the overlap of small cost, in the measure of Kwatra et al. 2003 ("Graphcut textures"): each face
/// between a voxel of one picture and one of the other costs the differences at both. The surface is a height over
/// (along, layer). Each layer is cut by dynamic programming (Efros & Freeman 2001, "Image quilting"), given the layers
/// above and below it, each line in depth likewise, in turn. That is begun twice, with layers that are drawn together
/// little by little and with one cut for all layers; the better result counts. Exact for one open layer, and never
/// worse than the best cut that is the same in all layers. Needs an overlap of 2. Throws Cancelled.
CutSurface cutOverlap(const OverlapCost& cost, Progress& progress);

} // namespace stf
