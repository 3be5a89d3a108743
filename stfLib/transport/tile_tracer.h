// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <cmath>
#include <limits>

namespace stf {

/// Exact traversal of a tile that repeats in x and y (Amanatides & Woo 1987, "A Fast Voxel Traversal Algorithm"),
/// shared by the walks, the exact single scattering and the camera march. Positions in voxel units (x, y of any value,
/// wrapped; z in 0..size.z, growing inward); `t` in the unit of the caller, `direction` in voxels per that unit. In
/// single precision for cameras, in double for walks.
class TileTracer {
public:
    explicit TileTracer(const Vec3i& size) : size_(size) {}

    /// Calls visit(voxel index, ix, iy, iz, t0, t1) for every voxel in order until it returns false, t reaches tMax or
    /// the ray leaves through the top or bottom. Returns the t where it ended. Pieces of zero length are skipped.
    template<class Real, class Visit>
    Real traverse(const Vec3<Real>& position, const Vec3<Real>& direction, Real tMax, Visit&& visit) const {
        constexpr Real kInf = std::numeric_limits<Real>::infinity();
        int v[3], step[3], crossed[3] = {0, 0, 0};
        Real tFirst[3], tNext[3], tDelta[3];
        for (int a = 0; a < 3; ++a) {
            const Real p = position[a], d = direction[a];
            Real cell = quickFloor(p);
            // On a face the voxel is the one that the ray enters.
            if (p == cell && d < 0) {
                cell -= 1;
            }
            v[a] = int(cell);
            step[a] = d > 0 ? 1 : -1;
            if (std::abs(d) > Real(1e-20)) {
                tDelta[a] = 1 / std::abs(d);
                tFirst[a] = tNext[a] = ((d > 0 ? cell + 1 : cell) - p) / d;
            } else {
                tDelta[a] = tFirst[a] = tNext[a] = kInf;
            }
        }
        v[0] = wrap(v[0], size_.x);
        v[1] = wrap(v[1], size_.y);
        const int stride[3] = {step[0], step[1] * size_.x, step[2] * size_.x * size_.y};
        // What a step over the tile's edge adds beside its stride.
        const int wrapped[2] = {-step[0] * size_.x, -step[1] * size_.x * size_.y};
        int index = v[0] + size_.x * (v[1] + size_.y * v[2]);
        Real t = 0;
        while (v[2] >= 0 && v[2] < size_.z) {
            const int a = tNext[0] < tNext[1] ? (tNext[0] < tNext[2] ? 0 : 2) : (tNext[1] < tNext[2] ? 1 : 2);
            const Real t1 = std::min(tNext[a], tMax);
            if (t1 > t) {
                if (!visit(index, v[0], v[1], v[2], t, t1)) {
                    return t;
                }
                t = t1;
            }
            if (tNext[a] >= tMax) {
                return tMax;
            }
            v[a] += step[a];
            index += stride[a];
            // Not by repeated addition: far along a ray a step would vanish in rounding, and the loop never end.
            tNext[a] = tFirst[a] + tDelta[a] * Real(++crossed[a]);
            if (a != 2 && (v[a] < 0 || v[a] >= size_[a])) {
                v[a] = v[a] < 0 ? size_[a] - 1 : 0;
                index += wrapped[a];
            }
        }
        return t;
    }

    static int wrap(int i, int n) {
        if (unsigned(i) < unsigned(n)) {
            return i; // the common case, without a division
        }
        const int m = i % n;
        return m < 0 ? m + n : m;
    }

private:
    Vec3i size_;
};

} // namespace stf
