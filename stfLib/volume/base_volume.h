// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/base/vec.h"

#include <string>
#include <vector>

namespace stf {

/// The base volume: one tile of a heterogeneous medium, periodic in x and y, z = 0 the top layer, z growing inward.
/// Dense arrays over size.x * size.y * size.z voxels, x fastest. Absent grids are empty.
struct BaseVolume {
    std::string name;
    Vec3i size{0, 0, 0};
    Vec3d voxelMm{1, 1, 1};
    std::vector<Rgb> extinction;    ///< 1/mm
    std::vector<Rgb> albedo;        ///< 0 to 1
    std::vector<float> g;           ///< mean cosine, -1 < g < 1; empty: 0
    std::vector<float> ior;         ///< relative to outside; empty: 1
    std::vector<float> surface;     ///< signed distance in mm, negative inside; empty: flat top
    std::vector<Rgb> emission;      ///< radiance per mm; empty: none
    Vec3d coreSigmaA{0, 0, 0};      ///< 1/mm
    Vec3d coreSigmaSPrime{0, 0, 0}; ///< 1/mm; both zero: no core given

    std::size_t voxelCount() const { return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z); }
    std::size_t index(int x, int y, int z) const {
        return std::size_t(x) + std::size_t(size.x) * (std::size_t(y) + std::size_t(size.y) * std::size_t(z));
    }
    Vec3d extentMm() const { return {size.x * voxelMm.x, size.y * voxelMm.y, size.z * voxelMm.z}; }
    bool hasCore() const { return maxComponent(coreSigmaA) > 0 || maxComponent(coreSigmaSPrime) > 0; }
    /// True where every column is the same: transport is one-dimensional.
    bool laterallyUniform() const;
    /// True where some voxel of the tile lies outside the material (relief or voids).
    bool hasRelief() const;
    /// 128-bit hash of everything that transport depends on, in hexadecimal.
    std::string contentHash() const;
};

/// 128-bit hash of a text, in hexadecimal.
std::string contentHashOf(const std::string& text);

/// Largest number of voxels that is accepted.
constexpr std::size_t kMaxVoxels = std::size_t(1) << 27;

/// The upper `layers` layers of a volume (1 to size.z).
BaseVolume cropDepth(const BaseVolume& volume, int layers);

/// The same medium with every voxel cut into eight. Throws Error where it has a relief (a distance is not constant over
/// a voxel) or too many voxels then.
BaseVolume subdivide(const BaseVolume& volume);

/// Throws Error naming the grid, how many values are wrong and the first of them: not finite, negative extinction,
/// albedo outside 0..1, |g| >= 1, index of refraction outside 0.1..10, wrong array sizes, zero or absurd tile sizes.
void validate(const BaseVolume& volume);

} // namespace stf
