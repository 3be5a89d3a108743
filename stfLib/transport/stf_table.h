// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/transport/direction_set.h"

#include <string>
#include <vector>

namespace stf {

/// Precomputed light transport of a base volume (form `classic`): what the published Shell Texture Function stores.
/// All per unit outside perpendicular irradiance of the light (DESIGN 3.6). Immutable once made; shared by threads.
///
/// A laterally uniform volume has a table of one column; callers wrap x and y by `size`.
class StfTable {
public:
    Vec3i size{0, 0, 0};
    Vec3d voxelMm{1, 1, 1};
    DirectionSet directions;

    std::vector<float> multiple;     ///< I_m: collided fluence, [voxel][direction][rgb]
    std::vector<Rgb> backlight;      ///< I_b: fluence for unit radiance entering from below, collided and not, [voxel]
    std::vector<float> transmitted;  ///< irradiance on the bottom, all of it, [column][direction][rgb]
    std::vector<float> direct;       ///< the part of it that never collided, exact, [column][direction][rgb]
    std::vector<Rgb> reflectedBelow; ///< share of diffuse light from below that comes back there, [column]

    // How it was made.
    std::string volumeHash, form = "classic";
    std::uint64_t photonsPerDirection = 0, seed = 0;
    double relativeError = 0; ///< noise of I_m, weighted by I_m, from the scatter of filtered batches
    double seconds = 0;

    std::size_t bytes() const;
    /// I_m of a voxel for light from given directions.
    Rgb multipleAt(std::size_t voxel, const DirectionWeights& w) const { return blend(multiple, voxel, w); }
    Rgb transmittedAt(std::size_t column, const DirectionWeights& w) const { return blend(transmitted, column, w); }
    Rgb directAt(std::size_t column, const DirectionWeights& w) const { return blend(direct, column, w); }

private:
    Rgb blend(const std::vector<float>& values, std::size_t item, const DirectionWeights& w) const {
        Rgb sum(0.0f);
        const float* const base = values.data() + item * std::size_t(directions.count()) * 3;
        for (int i = 0; i < w.count; ++i) {
            const float* const p = base + w.index[i] * 3;
            sum += Rgb(p[0], p[1], p[2]) * w.weight[i];
        }
        return sum;
    }
};

/// Writes and reads a table as .vdb; `key` names what it was made from and must agree on reading. Throw Error.
void writeTable(const StfTable& table, const std::string& key, const std::string& path);
StfTable readTable(const std::string& path, const std::string& key);

} // namespace stf
