// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/coarse_tile.h"

#include <string>
#include <vector>

namespace stf {

/// The tile as it is and made coarser by 2, 4, 8 ... for pixels that are larger than a voxel (a prefiltered tile). Made
/// with the shell, whatever the camera: moving it makes nothing again. Immutable, thread-safe.
class TilePyramid {
public:
    struct Level : CoarseTile {
        double error = 0; ///< of the mean radiance against the tile itself: rms over views, lights and channels
    };

    TilePyramid() = default;
    /// The tile alone.
    TilePyramid(const BaseVolume& volume, std::shared_ptr<const TileMedium> medium,
                std::shared_ptr<const StfTable> table);
    /// Adds levels as long as each changes the mean radiance, measured by marches, by at most `tolerance` (relative).
    /// `why` says where and why it ended.
    TilePyramid(const BaseVolume& volume, std::shared_ptr<const TileMedium> medium,
                std::shared_ptr<const StfTable> table, bool backlight, double tolerance);

    const std::vector<Level>& levels() const { return levels_; } ///< [0] is the tile itself
    const std::string& why() const { return why_; }
    /// The level for a footprint (mm, across, of the pixel on the tile's top): voxels of half its width at most, chosen
    /// at random between two neighbours so that no border shows. `u` in [0, 1).
    int levelFor(float footprintMm, float u) const;
    std::size_t bytes() const; ///< of what is beyond the tile itself

private:
    std::vector<Level> levels_;
    float voxelMm_ = 1;
    std::string why_;
};

} // namespace stf
