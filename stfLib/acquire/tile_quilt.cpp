// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/tile_quilt.h"

#include "stfLib/acquire/cut_surface.h"
#include "stfLib/acquire/periodicity.h"
#include "stfLib/acquire/tile_overlap.h"

#include <algorithm>

namespace stf {

namespace {

OverlapCost overlapCost(const TileField& f, int axis, int overlap, bool circle) {
    OverlapCost cost;
    cost.overlap = overlap;
    cost.length = f.size[1 - axis];
    cost.layers = f.size.z;
    cost.circle = circle;
    cost.difference.resize(std::size_t(overlap) * std::size_t(cost.length) * std::size_t(cost.layers));
    const int shift = f.size[axis] - overlap;
    // Cells without any difference make cuts wander; a little keeps them short.
    constexpr float kLeast = 1e-4f;
    parallelFor(std::size_t(cost.layers), 1, [&](std::size_t begin, std::size_t end) {
        for (int z = int(begin); z < int(end); ++z) {
            for (int j = 0; j < cost.length; ++j) {
                for (int i = 0; i < overlap; ++i) {
                    Vec3i own(i, j, z);
                    if (axis == 1) {
                        std::swap(own.x, own.y);
                    }
                    Vec3i beyond = own;
                    beyond[axis] += shift;
                    cost.difference[cost.index(i, j, z)] =
                        kLeast + contentDifference(f.at(f.index(own.x, own.y, own.z)),
                                                   f.at(f.index(beyond.x, beyond.y, beyond.z)), f.materials);
                }
            }
        }
    });
    return cost;
}

TileField quiltAxis(const TileField& f, int axis, int overlap, bool circle, double& cutError, Progress& progress) {
    requireOverlap(f, axis, overlap, 2);
    const CutSurface surface = cutOverlap(overlapCost(f, axis, overlap, circle), progress);
    const int length = f.size[1 - axis];
    const auto cutAt = [&](int j, int z) { return surface.cut[std::size_t(j) + std::size_t(length) * std::size_t(z)]; };
    TileField tile = joinSides(f, axis, overlap, [&](int i, int j, int z) { return i >= cutAt(j, z); });
    double sum = 0;
    for (int z = 0; z < f.size.z; ++z) {
        for (int j = 0; j < length; ++j) {
            Vec3i a(cutAt(j, z) - 1, j, z), b(cutAt(j, z), j, z);
            if (axis == 1) {
                std::swap(a.x, a.y);
                std::swap(b.x, b.y);
            }
            sum += double(
                contentDifference(tile.at(tile.index(a.x, a.y, a.z)), tile.at(tile.index(b.x, b.y, b.z)), f.materials));
        }
    }
    const double mean = sum / (double(length) * f.size.z), inside = neighbourDifference(f, axis);
    cutError = mean > 0 ? mean / std::max(inside, 1e-12) : 0;
    return tile;
}

} // namespace

QuiltedTile quiltSides(const TileField& field, const Vec3i& overlap, Progress& progress) {
    QuiltedTile q;
    const TileField once = quiltAxis(field, 0, overlap.x, false, q.cutX, progress);
    // What is now periodic along x stays so: the second cut closes on itself.
    q.tile = quiltAxis(once, 1, overlap.y, true, q.cutY, progress);
    return q;
}

} // namespace stf
