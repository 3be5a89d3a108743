// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/unit/volume/volumes.h"

#include <cmath>
#include <vector>

namespace stf::test {

/// A height field along x: depth of the surface (voxels) at the middles of columns. Its `surface` grid is linear in z
/// and between middles, so that the trilinear field's zero set is this polygon exactly.
struct Relief {
    std::vector<double> depth; ///< one per column, between 0.5 and size.z - 0.5

    /// Depth of the polygon at any x.
    double at(double x) const {
        const double p = x - 0.5, i = std::floor(p), f = p - i;
        const auto n = std::ptrdiff_t(depth.size());
        const auto wrap = [&](std::ptrdiff_t k) { return std::size_t((k % n + n) % n); };
        return depth[wrap(std::ptrdiff_t(i))] * (1 - f) + depth[wrap(std::ptrdiff_t(i) + 1)] * f;
    }
    /// Gives a volume this surface.
    void carve(BaseVolume& v) const {
        v.surface.resize(v.voxelCount());
        for (int z = 0; z < v.size.z; ++z) {
            for (int y = 0; y < v.size.y; ++y) {
                for (int x = 0; x < v.size.x; ++x) {
                    v.surface[v.index(x, y, z)] = float((depth[std::size_t(x)] - (z + 0.5)) * v.voxelMm.z);
                }
            }
        }
    }
    /// Length inside the material, in mm, of a line from the top at x (voxels) that goes down along (dx, dz), in voxels
    /// per mm, to the bottom; by small steps.
    double lengthInside(double x, double dx, double dz, double bottom, int steps = 4000) const {
        const double total = bottom / dz, dt = total / steps;
        double length = 0;
        for (int i = 0; i < steps; ++i) {
            const double t = (i + 0.5) * dt;
            length += dz * t > at(x + dx * t) ? dt : 0;
        }
        return length;
    }
};

inline Relief waves(int columns, double middle, double amplitude) {
    Relief r;
    for (int x = 0; x < columns; ++x) {
        r.depth.push_back(middle + amplitude * std::sin(2 * 3.14159265358979 * (x + 0.5) / columns));
    }
    return r;
}
inline Relief stairs(int columns, double low, double high) {
    Relief r;
    for (int x = 0; x < columns; ++x) {
        r.depth.push_back(2 * x < columns ? low : high);
    }
    return r;
}
/// A groove with straight sides, from `ridge` down to `valley` and back within the tile.
inline Relief groove(int columns, double ridge, double valley) {
    Relief r;
    for (int x = 0; x < columns; ++x) {
        r.depth.push_back(valley + (ridge - valley) * std::abs(2.0 * x / columns - 1));
    }
    return r;
}

} // namespace stf::test
