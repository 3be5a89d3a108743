// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <vector>

namespace stf {

/// A Gaussian over x and y of a periodic tile, against the noise of walks. Depth is not filtered: fluence bends at the
/// surface. How wide it may be is decided where its bias is measured (precompute).
class LateralFilter {
public:
    LateralFilter() = default;
    /// Standard deviation in mm; none where it is below a fifth of a voxel.
    LateralFilter(const Vec3i& size, const Vec3d& voxelMm, double sigmaMm);

    bool none() const { return kernelX_.size() < 2 && kernelY_.size() < 2; }
    /// Filters one layer of size.x * size.y items of `components` numbers in place. `fill`, where given, holds the
    /// share of each item that counts: an average over what is filled; empty items get it from their neighbours.
    void applyLayer(float* values, int components, const float* fill) const;
    /// All layers of [item][component], on all threads.
    void apply(std::vector<float>& values, int components, const std::vector<float>& fill) const;
    void apply(std::vector<Rgb>& values) const;

private:
    Vec3i size_{0, 0, 0};
    std::vector<float> kernelX_, kernelY_; ///< odd length, sum 1
};

} // namespace stf
