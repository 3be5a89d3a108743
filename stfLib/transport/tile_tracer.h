// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <cmath>
#include <limits>

namespace stf {

/// Exact traversal of a tile that repeats in x and y (Amanatides & Woo 1987, "A Fast Voxel Traversal Algorithm"),
/// shared by the walks, the exact single scattering and the camera march. Positions in voxel units (x, y of any value,
/// wrapped; z in 0..size.z, growing inward); `t` in the unit of the caller, `direction` in voxels per that unit.
class TileTracer {
public:
    explicit TileTracer(const Vec3i& size) : size_(size) {}

    /// Calls visit(voxel index, ix, iy, iz, t0, t1) for every voxel in order until it returns false, t reaches tMax or
    /// the ray leaves through the top or bottom. Returns the t where it ended. Pieces of zero length are skipped.
    template<class Visit>
    float traverse(const Vec3f& position, const Vec3f& direction, float tMax, Visit&& visit) const {
        constexpr float kInf = std::numeric_limits<float>::infinity();
        int v[3], step[3], crossed[3] = {0, 0, 0};
        float tFirst[3], tNext[3], tDelta[3];
        for (int a = 0; a < 3; ++a) {
            const float p = position[a], d = direction[a];
            float cell = std::floor(p);
            // On a face the voxel is the one that the ray enters.
            if (p == cell && d < 0) {
                cell -= 1;
            }
            v[a] = int(cell);
            step[a] = d > 0 ? 1 : -1;
            if (std::abs(d) > 1e-20f) {
                tDelta[a] = 1 / std::abs(d);
                tFirst[a] = tNext[a] = ((d > 0 ? cell + 1 : cell) - p) / d;
            } else {
                tDelta[a] = tFirst[a] = tNext[a] = kInf;
            }
        }
        v[0] = wrap(v[0], size_.x);
        v[1] = wrap(v[1], size_.y);
        float t = 0;
        while (v[2] >= 0 && v[2] < size_.z) {
            const int a = tNext[0] < tNext[1] ? (tNext[0] < tNext[2] ? 0 : 2) : (tNext[1] < tNext[2] ? 1 : 2);
            const float t1 = std::min(tNext[a], tMax);
            if (t1 > t) {
                const int index = v[0] + size_.x * (v[1] + size_.y * v[2]);
                if (!visit(index, v[0], v[1], v[2], t, t1)) {
                    return t;
                }
                t = t1;
            }
            if (tNext[a] >= tMax) {
                return tMax;
            }
            v[a] += step[a];
            // Not by repeated addition: far along a ray a step would vanish in rounding, and the loop never end.
            tNext[a] = tFirst[a] + tDelta[a] * float(++crossed[a]);
            if (a != 2) {
                v[a] = v[a] < 0 ? size_[a] - 1 : v[a] >= size_[a] ? 0 : v[a];
            }
        }
        return t;
    }

    static int wrap(int i, int n) {
        const int m = i % n;
        return m < 0 ? m + n : m;
    }

private:
    Vec3i size_;
};

} // namespace stf
