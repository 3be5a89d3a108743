// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/tile_field.h"

#include <numeric>

namespace stf {

std::vector<double> meanFractions(const TileField& field) {
    const std::size_t kinds = std::size_t(field.materials);
    std::vector<double> sums(kinds, 0.0);
    for (std::size_t i = 0; i < field.voxelCount(); ++i) {
        for (std::size_t m = 0; m < kinds; ++m) {
            sums[m] += double(field.fractions[i * kinds + m]);
        }
    }
    for (double& s : sums) {
        s /= double(field.voxelCount());
    }
    return sums;
}

TileField layersOf(const TileField& field, int first, int last) {
    TileField part = field;
    const std::ptrdiff_t layer = std::ptrdiff_t(field.size.x) * field.size.y, kinds = field.materials;
    part.size.z = last - first;
    part.fractions.assign(field.fractions.begin() + first * layer * kinds,
                          field.fractions.begin() + last * layer * kinds);
    if (!field.level.empty()) {
        part.level.assign(field.level.begin() + first * layer, field.level.begin() + last * layer);
    }
    return part;
}

} // namespace stf
