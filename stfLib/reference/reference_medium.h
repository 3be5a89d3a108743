// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace stf {

/// A base volume as it is, read point by point: its own coefficients (no scaled medium), the surface of its relief and
/// its index of refraction. Independent of the layer `transport`. Points are tile millimetres: x and y of any value,
/// z the depth, which counts as in the tile where it is not. Immutable, thread-safe.
class ReferenceMedium {
public:
    explicit ReferenceMedium(std::shared_ptr<const BaseVolume> volume);

    /// Of the voxel that holds a point. Where its maker left a voxel empty that the relief cuts, that of its neighbour
    /// deepest in the material.
    std::size_t voxelAt(const Vec3f& mm) const;
    const Rgb& extinction(std::size_t voxel) const { return volume_->extinction[voxel]; } ///< 1/mm
    const Rgb& albedo(std::size_t voxel) const { return volume_->albedo[voxel]; }
    float g(std::size_t voxel) const { return volume_->g.empty() ? 0.0f : volume_->g[voxel]; }
    bool emits() const { return emits_; }
    Rgb emission(std::size_t voxel) const { return emits_ ? volume_->emission[voxel] : Rgb(0.0f); }
    /// Of all voxels and channels, 1/mm; at least one tentative collision over the depth where something shines.
    float majorant() const { return majorant_; }

    bool refracts() const { return refracts_; }
    float ior(std::size_t voxel) const { return volume_->ior.empty() ? 1.0f : volume_->ior[voxel]; }
    /// Of the first material at or below a point of a relief.
    float iorBelow(const Vec3f& mm) const;

    bool hasRelief() const { return relief_; }
    /// Whether a point lies in the material.
    bool inside(const Vec3f& mm) const { return !relief_ || distance(mm) < 0; }
    /// mm, negative inside: trilinear between the middles of voxels, constant beyond the first and last layer's.
    float distance(const Vec3f& mm) const;
    /// What `distance` grows by along x, y and the depth, per mm, and the same over a voxel's width, without creases.
    Vec3f gradient(const Vec3f& mm) const;
    Vec3f smoothGradient(const Vec3f& mm) const;
    /// Most that `distance` changes over a mm.
    float steepest() const { return steepest_; }
    float leastVoxelMm() const { return float(minComponent(volume_->voxelMm)); }
    /// Whether a depth is above the tile's last layer.
    bool aboveLastLayer(float depthMm) const {
        return double(depthMm) < double(volume_->size.z - 1) * volume_->voxelMm.z;
    }

private:
    std::size_t wrapped(int x, int y, int z) const;
    Vec3f difference(const Vec3f& mm, float voxels) const;

    std::shared_ptr<const BaseVolume> volume_;
    std::vector<std::uint32_t> stand_; ///< voxel whose coefficients count; empty: each its own
    float majorant_ = 0, steepest_ = 0;
    bool refracts_ = false, relief_ = false, emits_ = false;
};

} // namespace stf
