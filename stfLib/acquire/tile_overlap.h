// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/tile_field.h"
#include "stfLib/base/error.h"
#include "stfLib/base/parallel.h"

#include <string>

namespace stf {

/// Throws Error where an overlap does not fit: `least` to half of the field.
inline void requireOverlap(const TileField& f, int axis, int overlap, int least) {
    if (overlap < least || overlap > f.size[axis] / 2) {
        throw Error("an overlap of " + std::to_string(overlap) + " voxels does not fit into a tile of " +
                    std::to_string(f.size[axis]) + " (" + std::to_string(least) + " to half)");
    }
}

/// Makes a field shorter by `overlap` voxels along an axis (0: x, 1: y): of its first `overlap` voxels those for which
/// `own(i, j, z)` is false (voxel i of the overlap, j along the other lateral axis) become what followed the tile's new
/// last voxel.
template<class Own>
TileField joinSides(const TileField& f, int axis, int overlap, Own own) {
    const std::size_t kinds = std::size_t(f.materials);
    TileField tile;
    tile.size = f.size;
    tile.size[axis] -= overlap;
    tile.voxelMm = f.voxelMm;
    tile.materials = f.materials;
    tile.fractions.resize(tile.voxelCount() * kinds);
    tile.level.resize(f.level.empty() ? 0 : tile.voxelCount());
    parallelFor(std::size_t(tile.size.z), 1, [&](std::size_t begin, std::size_t end) {
        for (int z = int(begin); z < int(end); ++z) {
            for (int y = 0; y < tile.size.y; ++y) {
                for (int x = 0; x < tile.size.x; ++x) {
                    const int i = axis == 0 ? x : y, j = axis == 0 ? y : x;
                    const std::size_t to = tile.index(x, y, z), a = f.index(x, y, z);
                    Vec3i beyond(x, y, z);
                    beyond[axis] += tile.size[axis];
                    const std::size_t from = i >= overlap || own(i, j, z) ? a : f.index(beyond.x, beyond.y, beyond.z);
                    for (std::size_t m = 0; m < kinds; ++m) {
                        tile.fractions[to * kinds + m] = f.fractions[from * kinds + m];
                    }
                    if (!f.level.empty()) {
                        tile.level[to] = f.level[from];
                    }
                }
            }
        }
    });
    return tile;
}

} // namespace stf
