// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/box_filter.h"

#include <algorithm>
#include <cmath>

namespace stf {

AxisWeights boxWeights(int oldCells, int newCells) {
    AxisWeights w;
    const double ratio = double(oldCells) / newCells;
    for (int i = 0; i < newCells; ++i) {
        const double lo = i * ratio, hi = i + 1 == newCells ? oldCells : (i + 1) * ratio;
        const int from = std::min(int(lo), oldCells - 1);
        w.first.push_back(from);
        w.begin.push_back(int(w.weights.size()));
        for (int j = from; j < oldCells && j < hi; ++j) {
            const double part = std::min(hi, j + 1.0) - std::max(lo, double(j));
            if (part > 1e-12 || j == from) {
                w.weights.push_back(std::max(0.0, part) / (hi - lo));
            }
        }
    }
    w.begin.push_back(int(w.weights.size()));
    return w;
}

AxisWeights boxOrLinearWeights(int oldCells, int newCells) {
    if (newCells <= oldCells) {
        return boxWeights(oldCells, newCells);
    }
    AxisWeights w;
    for (int i = 0; i < newCells; ++i) {
        const double at = std::clamp((i + 0.5) * oldCells / newCells - 0.5, 0.0, oldCells - 1.0);
        const int from = std::min(int(at), std::max(0, oldCells - 2));
        w.first.push_back(from);
        w.begin.push_back(int(w.weights.size()));
        w.weights.push_back(1 - (at - from));
        if (from + 1 < oldCells) {
            w.weights.push_back(at - from);
        }
    }
    w.begin.push_back(int(w.weights.size()));
    return w;
}

} // namespace stf
