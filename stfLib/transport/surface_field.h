// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <array>
#include <cstdint>
#include <vector>

namespace stf {

/// The surface of a tile's relief: the zero set of the signed distance, trilinear between the middles of voxels,
/// periodic in x and y, constant beyond the middles of the first and last layer. Positions in voxel units, z inward.
class SurfaceField {
public:
    SurfaceField() = default;
    /// Distances in mm, negative inside; a field without a voxel outside is empty (the flat top is the surface).
    SurfaceField(const Vec3i& size, const Vec3d& voxelMm, const std::vector<float>& distance);

    bool empty() const { return distance_.empty(); }
    /// Whether the surface may pass through a voxel; the others are wholly inside or outside.
    bool crossedBySurface(std::size_t voxel) const { return kind_[voxel] == 2; }
    bool insideVoxel(std::size_t voxel) const { return kind_[voxel] == 1; }

    float value(const Vec3f& position) const;
    /// Unit normal in mm space, pointing out of the material.
    Vec3f normal(const Vec3f& position) const;
    /// The same over a voxel's width: continuous, where `normal` has creases between the middles of voxels.
    Vec3f smoothNormal(const Vec3f& position) const;
    bool inside(const Vec3f& position) const { return value(position) < 0; }

    /// First t in (t0, t1] of the line where a walker that is `inside` (or not) passes to the other side; infinity
    /// where it stays. The stretch must lie within `voxel` (wrapped indices). A walker on the wrong side by rounding
    /// passes at once, unless it is on its way back.
    float crossing(const Vec3i& voxel, const Vec3f& position, const Vec3f& direction, float t0, float t1,
                   bool inside) const;

    /// Splits a stretch within one voxel into pieces(a, b, inside).
    template<class Visit>
    void pieces(const Vec3i& voxel, const Vec3f& position, const Vec3f& direction, float t0, float t1,
                Visit&& visit) const {
        bool in = inside(position + direction * (t0 + 1e-4f * (t1 - t0)));
        for (int guard = 0; t0 < t1 && guard < 16; ++guard) {
            const float t = crossing(voxel, position, direction, t0, t1, in);
            const float end = t < t1 ? t : t1;
            if (end > t0) {
                visit(t0, end, in);
            }
            t0 = end;
            in = !in;
        }
    }

    /// Share of each voxel that lies inside; error below 0.4 % of a voxel, none where the surface is level.
    std::vector<float> fill() const;

private:
    float at(int x, int y, int z) const;
    /// Number of the cell between the middles of voxels that starts at voxel (x, y, z), z from -1, others wrapped.
    std::size_t cellNumber(int x, int y, int z) const {
        return std::size_t(x) + std::size_t(size_.x) * (std::size_t(y) + std::size_t(size_.y) * std::size_t(z + 1));
    }
    Vec3i size_{0, 0, 0};
    Vec3d voxelMm_{1, 1, 1};
    std::vector<float> distance_;
    std::vector<std::uint8_t> kind_; ///< of voxels: 0 outside, 1 inside, 2 crossed
    std::vector<std::int32_t> cell_; ///< of cells between middles: into corners_, or negative: no change of sign
    std::vector<std::array<float, 8>> corners_;
};

} // namespace stf
