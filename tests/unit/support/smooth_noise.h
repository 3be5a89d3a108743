// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/random.h"
#include "stfLib/transport/lateral_filter.h"

#include <vector>

namespace stf::test {

/// Independent uniform numbers from -.5 to .5 per voxel, layer by layer under a Gaussian (mm, periodic).
inline std::vector<float> smoothNoise(const Vec3i& size, const Vec3d& voxelMm, double sigmaMm, std::uint64_t seed) {
    CounterRng rng(seed, 1);
    std::vector<Rgb> noise(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z));
    for (Rgb& n : noise) {
        n = Rgb(rng.uniform() - 0.5f);
    }
    LateralFilter(size, voxelMm, sigmaMm).apply(noise);
    std::vector<float> out;
    for (const Rgb& n : noise) {
        out.push_back(n.x);
    }
    return out;
}

} // namespace stf::test
