// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/tile_field.h"

namespace stf {

/// How badly the sides of a tile fit: the mean content difference of voxels that meet across the wrap, relative to that
/// of neighbours inside. 1 is a wrap that does not show; 0 where both are 0.
struct PeriodicityError {
    double x = 0, y = 0;
};
PeriodicityError periodicityError(const TileField& field);

/// Mean content difference of neighbours along an axis (0: x, 1: y), without the wrap.
double neighbourDifference(const TileField& field, int axis);

} // namespace stf
