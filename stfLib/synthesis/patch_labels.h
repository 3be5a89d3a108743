// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/exemplar.h"
#include "stfLib/synthesis/surface_charts.h"

namespace stf {

/// Which chart each vertex takes its coordinate from, and which part of the sample that chart shows there.
struct PatchLabels {
    std::vector<int> entry;    ///< of the chart cover, per vertex
    std::vector<Vec2f> offset; ///< mm, added to the entry's coordinate

    Vec2f coord(const ChartCover& cover, std::size_t v) const { return cover.coord[std::size_t(entry[v])] + offset[v]; }
};

/// The same place of the tile nearest to zero.
Vec2f nearestImage(const Vec2f& d, const Vec2d& tileMm);

/// Across a link from u to v (step in the frame of the field): the coordinate that u's patch has at v, by the chart
/// where it reaches so far, else by the step.
Vec2f continued(const ChartCover& cover, const PatchLabels& labels, std::size_t u, std::size_t v, const Vec2f& step);

struct SeamOptions {
    int sweeps = 2;
    double strainCost = 2; ///< per squared logarithm of stretch at a vertex, in units of the sample's own error
    double remoteCost = 0.02;
    double lengthCost = 0.4; ///< of a seam per link, however well it fits
};

/// Labels with seams where they are seen least: alpha expansion (Boykov, Veksler & Zabih 2001, "Fast approximate energy
/// minimization via graph cuts") over charts, with the seam cost of Kwatra et al. 2003, "Graphcut textures", in
/// appearance space. Charts that do not touch are expanded at the same time. Deterministic for any number of threads.
PatchLabels cutSeams(const SurfaceGraph& graph, const ChartCover& cover, const std::vector<Vec2f>& offsets,
                     const Exemplar& exemplar, const SeamOptions& options, Progress& progress);

} // namespace stf
