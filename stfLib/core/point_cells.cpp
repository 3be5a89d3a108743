// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/point_cells.h"

#include <algorithm>
#include <numeric>

namespace stf {

PointCells::PointCells(const std::vector<Vec3f>& points, float cell) {
    Box3f box;
    for (const Vec3f& p : points) {
        box.add(p);
    }
    low_ = points.empty() ? Vec3f(0.0f) : box.lo;
    // The number of cubes is bounded, whatever was asked for.
    cell_ = std::max({cell, points.empty() ? 0.0f : maxComponent(box.hi - box.lo) / float(kMost - 2), 1e-30f});
    std::vector<std::uint64_t> keys(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        keys[i] = key(cube(points[i]));
    }
    order_.resize(points.size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
    for (std::uint32_t i = 0; i < order_.size();) {
        std::uint32_t end = i + 1;
        while (end < order_.size() && keys[order_[end]] == keys[order_[i]]) {
            ++end;
        }
        ranges_[keys[order_[i]]] = {i, end};
        i = end;
    }
}

} // namespace stf
