// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/tile_field.h"
#include "stfLib/base/progress.h"

namespace stf {

/// A tile and how well its two cuts hide: the mean content difference across their faces relative to that of neighbours
/// of the field; 1 does not show.
struct QuiltedTile {
    TileField tile;
    double cutX = 0, cutY = 0;
};

/// Makes a field periodic along x and y by quilting: the tile becomes `overlap` voxels smaller along each axis; within
/// its first voxels a surface of least difference (cut_surface.h) leads from what follows its last ones to its own.
/// Every voxel is one of the field: features stay sharp. Throws Error where the overlap is not 2 to half of the field;
/// Cancelled.
QuiltedTile quiltSides(const TileField& field, const Vec3i& overlap, Progress& progress);

} // namespace stf
