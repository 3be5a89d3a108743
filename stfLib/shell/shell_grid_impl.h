// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer, its tests and benchmarks.

#include "stfLib/shell/shell_grid.h"
#include "stfLib/shell/shell_level.h"

#include <vector>

namespace stf {

/// All of a built grid.
struct ShellGridData {
    std::vector<ShellLevel> levels; ///< finest first
    std::vector<ShellLevelReport> reports;
    ShellGridReport report;
    std::vector<Vec3i> triangles; ///< points of the surface's triangles
    std::size_t points = 0;       ///< of the surface
    double mmPerUnit = 1;
    Vec2d tileMm{1, 1};
    double texelMm = 1; ///< what errors of the reports are measured in

    std::size_t sampleCount() const;
};

struct ShellGrid::Impl : ShellGridData {};

/// The reader behind an Accessor: finds corners, and adds up what they say.
class ShellReader {
public:
    explicit ShellReader(const ShellGridData& grid);
    bool lookup(const Vec3f& objectPoint, int level, ShellLookup& out, const Rgb* core);
    void prefer(const Vec3f& normal) { prefer_ = normal; }
    void prefetch(const Vec3f& objectPoint, int level);

    struct LevelView {
        const ShellLevel* level = nullptr;
        const ShellLeaf* leaf = nullptr; ///< last one found; never null where the level has leaves
        double perVoxel = 0;
        float mmPerUnit = 1, voxelMm = 0, depthLow = 0, depthStep = 0;
    };
    struct Corners {
        const ShellSample* sample[8]; ///< x slowest
        unsigned present = 0;         ///< bit c: corner c has a sample
        std::uint32_t number[8];      ///< in the whole grid
    };
    /// Samples of the voxels whose middles surround a place, whose whole part in voxels is `floor`; false where there
    /// is none.
    bool corners(const Vec3i& floor, int level, Corners& out) {
        return corners(views_[std::size_t(level)], floor.x, floor.y, floor.z, out);
    }

private:
    static void rowOf(const ShellLeaf& leaf, int row, int z, int corner, Corners& out);
    bool corners(LevelView& view, int x, int y, int z, Corners& out) const;
    /// What the corners say, by a reference; see addUp in the kernel.
    int addUpFrom(const LevelView& view, const Corners& c, int ref, const Vec3f& f, ShellLookup& out,
                  float (&weights)[8]) const;

    /// What a prefetch found, for the lookup that it was made for.
    struct Ahead {
        const LevelView* view = nullptr;
        int x = 0, y = 0, z = 0;
        bool found = false;
        Corners corners;
        bool is(const LevelView& v, int i, int j, int k) const { return view == &v && x == i && y == j && z == k; }
    };

    std::vector<LevelView> views_;
    Ahead ahead_[2]; ///< of the last two
    int nextAhead_ = 0;
    Vec2f tile_;
    Vec3f prefer_{0, 0, 0};
};

} // namespace stf
