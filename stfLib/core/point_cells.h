// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace stf {

/// Points sorted into the cubes of a grid, to find those near a place. Immutable; any number of threads.
class PointCells {
public:
    /// `cell`: edge of a cube, about the distance that is asked for later.
    PointCells(const std::vector<Vec3f>& points, float cell);

    /// Calls visit(index) for every point in the cubes that a ball meets, in an order that depends on the points only.
    template<class Visit>
    void near(const Vec3f& place, float radius, Visit&& visit) const {
        const Vec3i lo = cube(place - Vec3f(radius)), hi = cube(place + Vec3f(radius));
        for (int z = lo.z; z <= hi.z; ++z) {
            for (int y = lo.y; y <= hi.y; ++y) {
                for (int x = lo.x; x <= hi.x; ++x) {
                    const auto it = ranges_.find(key({x, y, z}));
                    for (std::uint32_t i = it == ranges_.end() ? 0 : it->second.first;
                         it != ranges_.end() && i < it->second.second; ++i) {
                        visit(std::size_t(order_[i]));
                    }
                }
            }
        }
    }
    float cell() const { return cell_; }

private:
    static constexpr int kMost = (1 << 20) - 1; // cubes along an axis

    Vec3i cube(const Vec3f& p) const {
        const Vec3f c = (p - low_) / cell_;
        const auto index = [](float f) { return int(std::floor(std::min(std::max(f, -1.0f), float(kMost)))); };
        return {index(c.x), index(c.y), index(c.z)};
    }
    static std::uint64_t key(const Vec3i& c) {
        return std::uint64_t(c.x + 1) | std::uint64_t(c.y + 1) << 21 | std::uint64_t(c.z + 1) << 42;
    }

    Vec3f low_;
    float cell_;
    std::vector<std::uint32_t> order_;
    std::unordered_map<std::uint64_t, std::pair<std::uint32_t, std::uint32_t>> ranges_;
};

} // namespace stf
