// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_repair.h"
#include "stfLib/acquire/mesh_tree.h"

#include <cstdint>
#include <memory>

namespace stf {

/// The voxels of a tile. Its coordinates: mm, x and y from a corner, z the depth below the top (inward).
struct TileGrid {
    Vec3i size{1, 1, 1};
    Vec3d voxelMm{1, 1, 1};
    Vec3d extentMm() const { return {size.x * voxelMm.x, size.y * voxelMm.y, size.z * voxelMm.z}; }
};

/// A stretch of a line along the depth: of one of the lines of a column of voxels.
struct Stretch {
    int line;
    double from, to; ///< depth in mm, within the tile
};

/// What of vertical lines lies inside a mesh that repeats with the tile. A line crosses each triangle once or not at
/// all, shared edges and corners included (half-open rule on the projection, the same arithmetic for both neighbours);
/// crossings add up to the exact winding number of the closed mesh, at any depth. Less that of the caps, it is the
/// generalised winding number of an open one: inside is where it exceeds 1/2. Immutable, any number of threads.
class MeshColumns {
public:
    /// A mesh in tile coordinates, that faces outward. Throws Error for a mesh so much larger than the tile that it
    /// would take more than `maxBytes`.
    MeshColumns(MendedMesh mesh, const TileGrid& grid, double maxBytes = 4e9);

    /// Appends the stretches inside, for the column of voxels (x, y) and lines at these places in it (0 to 1).
    void inside(int x, int y, const std::vector<Vec2d>& lines, std::vector<Stretch>& out) const;
    /// Depth at which each line first meets a triangle (of the caps, too), which may be above the tile; infinity for
    /// none.
    std::vector<double> first(int x, int y, const std::vector<Vec2d>& lines) const;

    const MendedMesh& mended() const { return mended_; }

private:
    struct Item {
        std::uint32_t triangle;
        std::int16_t imageX, imageY; ///< which repetition of the tile the column is in
    };
    struct Crossing {
        int line, turn; ///< turn: what the winding number changes by
        int imageX, imageY;
        double depth;
    };
    void crossings(int x, int y, const std::vector<Vec2d>& lines, std::vector<Crossing>& out) const;
    void preparePatches();
    /// Winding number of the caps where the corners of voxels (u, v) are, at these depths in voxels.
    void capWinding(int u, int v, const std::vector<int>& depths, double* out) const;
    /// Sets the thresholds at those of n corners where blocks of voxels tell them; the others are to be asked.
    std::vector<char> cornersToAsk(std::vector<int>& corner, const Vec3i& n) const;
    /// Winding number from which on a voxel is inside, that of an open mesh; kMixed + i: not the same throughout it,
    /// samples_[i] tell.
    int threshold(int unwrappedX, int unwrappedY, int z) const;
    void insideOpen(int unwrappedX, int unwrappedY, const Vec2d& at, int line, const Crossing* begin,
                    const Crossing* end, std::vector<Stretch>& out) const;

    static constexpr int kMixed = 1 << 20;
    MendedMesh mended_;
    TriangleMesh closed_; ///< mesh and caps
    TileGrid grid_;
    Box3d box_;
    std::vector<std::size_t> start_; ///< of each column in items_
    std::vector<Item> items_;
    std::unique_ptr<TriangleTree> caps_, tree_; ///< of an open mesh
    Vec3i patchFrom_, patchSize_{0, 0, 0};      ///< unwrapped voxels around an open mesh
    std::vector<int> threshold_;
    std::vector<std::uint64_t> samples_; ///< a bit for each of 4 x 4 x 4 places: inside
};

} // namespace stf
