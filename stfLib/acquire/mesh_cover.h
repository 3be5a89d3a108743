// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_columns.h"
#include "stfLib/base/progress.h"

#include <limits>

namespace stf {

/// What the matrix fills: all of the tile, what is below a relief, or what is inside meshes.
struct CoverBody {
    enum class Kind { Full, Relief, Meshes } kind = Kind::Full;
    std::vector<const MeshColumns*> meshes;                       ///< the relief, or the meshes
    double reliefFloor = std::numeric_limits<double>::infinity(); ///< depth of its surface where it has none, mm
    int material = -1;                                            ///< slot of its fractions
};

/// A mesh in the matrix, in ascending order of priority.
struct CoverObject {
    const MeshColumns* columns = nullptr;
    int material = -1; ///< slot of its fractions; -1: a void that a surface cuts out
};

struct TileCover {
    std::vector<float> fractions;  ///< for each voxel (x fastest) one for each slot
    std::vector<char> protrudes;   ///< for each object: some of it is where the matrix, or what lies below, is not
    double reliefMissing = 0;      ///< share of the lines that do not meet the relief
    std::vector<double> meanShare; ///< of each slot, of the whole tile
};

/// The stretches of vertical lines that a body fills.
void bodyStretches(const CoverBody& body, const TileGrid& grid, int x, int y, const std::vector<Vec2d>& lines,
                   std::vector<Stretch>& out, std::size_t* missing = nullptr);

/// Volume fractions of each voxel. Along the depth they are exact; across, lines at 64 places of a column stand for it,
/// a (0, 6, 2)-net: any upright plane is off by at most 1/128 of a voxel, curved ones by much less in the mean.
/// The same for any number of threads.
TileCover coverTile(const CoverBody& body, const std::vector<CoverObject>& objects, const TileGrid& grid, int slots,
                    Progress& progress);

} // namespace stf
