// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/volume/base_volume.h"

#include <vector>

namespace stf {

/// A Gaussian over x and y of a periodic tile, against the noise of walks. Fluence cannot change faster than over a
/// mean free path, so the width is one transport mean free path, at most 1.5 voxels: noise falls two to three times, and
/// the bias stays below it (bench/table_filter.cpp measures both). Depth is not filtered: fluence bends at the surface.
class LateralFilter {
public:
    explicit LateralFilter(const BaseVolume& volume);
    /// The same with a given width: standard deviation in mm, whatever number of voxels that is.
    LateralFilter(const Vec3i& size, const Vec3d& voxelMm, double sigmaMm);

    /// Filters any number of layers of size.x * size.y values in place; no effect on a tile of one column.
    void apply(std::vector<Rgb>& values) const;
    /// Standard deviation of white noise before over after, at least 1; of walks, whose tracks cross voxels, less.
    double noiseGain() const;

private:
    Vec3i size_;
    std::vector<float> kernelX_, kernelY_; ///< odd length, sum 1
};

} // namespace stf
