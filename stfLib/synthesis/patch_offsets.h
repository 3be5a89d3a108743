// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/exemplar.h"
#include "stfLib/synthesis/surface_charts.h"

namespace stf {

struct OffsetOptions {
    std::uint64_t seed = 0;
    /// Cost of showing the same place again nearby, in units of a seam as good as the sample's own. Large: where places
    /// are alike, seams hardly show, and repetition does.
    double repetition = 40;
    double usage = 1.0;   ///< cost of places used twice their share, in the same units
    double balance = 1.0; ///< cost of distributions of parameters that are off by as much as they may
    int sweeps = 5;       ///< how often every chart chooses again, after the first time
};

/// Which part of the sample each chart shows: an offset in tile millimetres, added to the chart's coordinates.
/// k-coherence over whole patches: candidates are what the overlapping charts show there, continued, and the texels
/// alike it (in detail and in structure); the one whose appearance in the overlap differs least is taken, coarse stack
/// level first, with costs for places that are overused or were shown nearby. One chart after the other, each beside
/// those that already chose; then all again. Deterministic by seed for any number of threads.
std::vector<Vec2f> chooseOffsets(const SurfaceGraph& graph, const ChartCover& cover, const Exemplar& exemplar,
                                 double mmPerUnit, const OffsetOptions& options, Progress& progress);

} // namespace stf
