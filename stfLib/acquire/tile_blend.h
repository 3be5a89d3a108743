// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/tile_field.h"

namespace stf {

/// Makes a field periodic along x and y by cross-fading its sides: within `overlap` voxels of a side, each voxel and
/// its mirror image in the plane where tiles meet exchange part of their content, half of it at the side, none at the
/// end of the overlap. What one gains the other gives: the size stays, and so does every material's volume, exactly.
/// Throws Error where the overlap is not 1 to half of the field.
TileField blendSides(const TileField& field, const Vec3i& overlap);

} // namespace stf
