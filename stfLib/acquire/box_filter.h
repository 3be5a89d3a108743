// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace stf {

/// What each cell of a new division of an axis takes of the old cells: `weights[begin[i] .. begin[i + 1])` belong to
/// new cell i and old cells first[i], first[i] + 1 ... Weights of a new cell add up to 1.
struct AxisWeights {
    std::vector<int> first, begin;
    std::vector<double> weights;
    int count(int i) const { return begin[std::size_t(i) + 1] - begin[std::size_t(i)]; }
};

/// Both divisions cut the same length into equal cells: each new cell is the mean over its part, so that the sum times
/// the size of a cell is kept.
AxisWeights boxWeights(int oldCells, int newCells);

/// The same where cells grow; where they shrink, linear between the middles of old cells, constant beyond.
AxisWeights boxOrLinearWeights(int oldCells, int newCells);

} // namespace stf
