// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/tile_blend.h"

#include "stfLib/acquire/tile_overlap.h"

namespace stf {

namespace {

void exchange(float& a, float& b, float share) {
    const float moved = share * (b - a);
    a += moved;
    b -= moved;
}

void blendAxis(TileField& f, int axis, int overlap) {
    requireOverlap(f, axis, overlap, 1);
    const std::size_t kinds = std::size_t(f.materials);
    parallelFor(std::size_t(f.size.z), 1, [&](std::size_t begin, std::size_t end) {
        for (int z = int(begin); z < int(end); ++z) {
            for (int j = 0; j < f.size[1 - axis]; ++j) {
                for (int i = 0; i < overlap; ++i) {
                    Vec3i at(i, j, z);
                    if (axis == 1) {
                        std::swap(at.x, at.y);
                    }
                    Vec3i mirrored = at;
                    mirrored[axis] = f.size[axis] - 1 - i;
                    const std::size_t a = f.index(at.x, at.y, at.z), b = f.index(mirrored.x, mirrored.y, mirrored.z);
                    const float share = 0.5f - 0.5f * (float(i) + 0.5f) / float(overlap);
                    for (std::size_t m = 0; m < kinds; ++m) {
                        exchange(f.fractions[a * kinds + m], f.fractions[b * kinds + m], share);
                    }
                    if (!f.level.empty()) {
                        exchange(f.level[a], f.level[b], share);
                    }
                }
            }
        }
    });
}

} // namespace

TileField blendSides(const TileField& field, const Vec3i& overlap) {
    TileField tile = field;
    blendAxis(tile, 0, overlap.x);
    blendAxis(tile, 1, overlap.y);
    return tile;
}

} // namespace stf
