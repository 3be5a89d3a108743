// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/tile_walks.h"

namespace stf {

/// What is known of one light direction.
struct DirectionLight {
    /// Mean of all rounds of each half of the groups, [voxel][component], per perpendicular irradiance: what the halves
    /// differ by is noise.
    std::vector<float> half[2];
    std::vector<float> uncollided;              ///< only under a refracting relief
    std::vector<double> below, belowUncollided; ///< sums over photons, [column][rgb]
    Vec3d above{0, 0, 0};
    std::uint64_t photons = 0;
    double noise = 0, voxelNoise = 0; ///< squared rms of the noise of what is read, of what is stored
    double perPhoton = 0;             ///< noise * photons: what one photon's walk varies by
};

/// Walks all directions of the table's set, in rounds, until the noise fits into what the other errors leave of the
/// wanted one, and factors what they found: fills `multiple`, `single`, `error.noise` and `error.truncation`.
std::vector<DirectionLight> walkDirections(TileWalks& c, StfTable& t);

} // namespace stf
