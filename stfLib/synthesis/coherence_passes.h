// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/patch_labels.h"

namespace stf {

struct CoherenceOptions {
    int passes = 6;
    int similar = 3;        ///< texels alike that are tried, besides the neighbours' own
    double breakCost = 0.6; ///< of a link across which coordinates jump, in squares of the sample's own error
    std::uint64_t seed = 0;
};

/// Correction passes of k-coherence synthesis (Tong et al. 2002) beside seams: a vertex takes the coordinate that one
/// of its neighbours foresees for it, or of a texel alike, where its neighbourhood then differs less from the sample's.
/// Each pass updates vertices of which no two are neighbours, so that the order and the number of threads do not matter
/// and the cost never grows. Returns how many vertices changed.
std::size_t correctByCoherence(const SurfaceGraph& graph, const SurfaceSteps& steps, const ChartCover& cover,
                               const Exemplar& exemplar, const CoherenceOptions& options, PatchLabels& labels,
                               Progress& progress);

} // namespace stf
