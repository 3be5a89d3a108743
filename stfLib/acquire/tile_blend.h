// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/tile_field.h"

namespace stf {

/// Makes a field periodic along x and y by cross-fading: the tile becomes `overlap` voxels smaller along each axis; its
/// first voxels fade from what follows its last ones to its own. Where contents mix, fractions are then scaled so that
/// every material keeps its mean of before (iterative proportional fitting, Deming & Stephan 1940): only voxels that
/// hold several materials change by that. Throws Error where the overlap is not 1 to half of the field.
TileField blendSides(const TileField& field, const Vec3i& overlap);

/// Scales fractions, the void's included, until each material has its mean; voxels of one material stay what they are.
/// Returns the largest difference from a mean that is left.
double fitMeans(TileField& field, const std::vector<double>& means);

} // namespace stf
