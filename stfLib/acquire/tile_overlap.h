// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/tile_field.h"
#include "stfLib/base/error.h"
#include "stfLib/base/parallel.h"

#include <string>

namespace stf {

/// Makes a field shorter by `overlap` voxels along an axis (0: x, 1: y). Its first `overlap` voxels become a mixture of
/// their own (`own(i, j, z)`, 0 to 1, for voxel i of the overlap, j along the other lateral axis) and of what followed
/// the tile's new last voxel. Throws Error where the overlap is not 1 to half of the field.
template<class Own>
TileField joinSides(const TileField& f, int axis, int overlap, Own own) {
    if (overlap < 1 || overlap > f.size[axis] / 2) {
        throw Error("an overlap of " + std::to_string(overlap) + " voxels does not fit into a tile of " +
                    std::to_string(f.size[axis]) + " (at most half)");
    }
    TileField tile;
    tile.size = f.size;
    tile.size[axis] -= overlap;
    tile.voxelMm = f.voxelMm;
    tile.materials = f.materials;
    tile.fractions.resize(tile.voxelCount() * std::size_t(f.materials));
    tile.level.resize(f.level.empty() ? 0 : tile.voxelCount());
    parallelFor(std::size_t(tile.size.z), 1, [&](std::size_t begin, std::size_t end) {
        for (int z = int(begin); z < int(end); ++z) {
            for (int y = 0; y < tile.size.y; ++y) {
                for (int x = 0; x < tile.size.x; ++x) {
                    const int i = axis == 0 ? x : y, j = axis == 0 ? y : x;
                    const std::size_t to = tile.index(x, y, z), a = f.index(x, y, z);
                    Vec3i beyond(x, y, z);
                    beyond[axis] += tile.size[axis];
                    const std::size_t b = i < overlap ? f.index(beyond.x, beyond.y, beyond.z) : a;
                    const float w = i < overlap ? own(i, j, z) : 1.0f;
                    for (int m = 0; m < f.materials; ++m) {
                        tile.fractions[to * std::size_t(f.materials) + std::size_t(m)] =
                            w * f.at(a)[m] + (1 - w) * f.at(b)[m];
                    }
                    if (!f.level.empty()) {
                        tile.level[to] = w * f.level[a] + (1 - w) * f.level[b];
                    }
                }
            }
        }
    });
    return tile;
}

} // namespace stf
