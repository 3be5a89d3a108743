// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace stf {

/// What a tile is made of before coefficients: fractions of materials per voxel, and where a surface is wanted, a level
/// that changes sign there.
struct TileField {
    Vec3i size{0, 0, 0};
    Vec3d voxelMm{1, 1, 1};
    int materials = 0;            ///< without voids
    std::vector<float> fractions; ///< [voxel][material], x fastest; what is missing to 1 is void
    std::vector<float> level;     ///< in the unit of the scan, negative inside; empty: no surface

    std::size_t voxelCount() const { return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z); }
    std::size_t index(int x, int y, int z) const {
        return std::size_t(x) + std::size_t(size.x) * (std::size_t(y) + std::size_t(size.y) * std::size_t(z));
    }
    const float* at(std::size_t voxel) const { return fractions.data() + voxel * std::size_t(materials); }
};

/// Share of two voxels that holds another material, 0 to 1: half the sum of the differences of all fractions, the
/// void's included.
inline float contentDifference(const float* a, const float* b, int materials) {
    float sum = 0, missing = 0;
    for (int m = 0; m < materials; ++m) {
        const float d = a[m] - b[m];
        sum += std::abs(d);
        missing += d;
    }
    return 0.5f * (sum + std::abs(missing));
}

/// Mean fraction of each material.
std::vector<double> meanFractions(const TileField& field);

/// Layers [first, last) of a field.
TileField layersOf(const TileField& field, int first, int last);

} // namespace stf
