// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/patch_labels.h"

namespace stf {

/// What every vertex of a surface shows, and between which vertices that is continuous.
struct SurfaceCoords {
    std::vector<Vec2f> coord; ///< per vertex, tile mm, any representative modulo the tile
    std::vector<Vec2f> delta; ///< per link of the graph: the coordinate there less that here, if it is continuous
    std::vector<char> broken; ///< per link: it is not, a seam runs across
};

/// Gives small breaks between patches back to the patches: where two patches differ by a few texels only (the same
/// place of the sample, reached over different ways), coordinates are shifted, smoothly decaying away from the seam,
/// until they agree. Larger breaks stay seams. `limitTexels`: beyond it a break is left alone.
SurfaceCoords healBreaks(const SurfaceGraph& graph, const SurfaceSteps& steps, const ChartCover& cover,
                         const Exemplar& exemplar, const PatchLabels& labels, double limitTexels, Progress& progress);

/// Gives fragments of patches of less than `least` vertices to the patch that they touch most and that reaches them.
void absorbFragments(const SurfaceGraph& graph, const ChartCover& cover, std::size_t least, PatchLabels& labels);

} // namespace stf
