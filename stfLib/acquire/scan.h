// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/base/vec.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// A measured volume, or a part of one: one value per voxel, x fastest, at the middles of voxels.
struct Scan {
    Vec3i size{0, 0, 0};
    Vec3d spacingMm{1, 1, 1}; ///< distance of the middles of voxels
    std::vector<float> values;

    std::size_t voxelCount() const { return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z); }
    std::size_t index(int x, int y, int z) const {
        return std::size_t(x) + std::size_t(size.x) * (std::size_t(y) + std::size_t(size.y) * std::size_t(z));
    }
};

/// How a file stores a value.
enum class ScanType { UInt8, Int8, UInt16, Int16, UInt32, Int32, Float32, Float64 };
std::size_t bytesOf(ScanType type);
const char* nameOf(ScanType type);
/// "uint8", "int16", "float32" and so on; throws Error for another name, telling those.
ScanType scanTypeOf(const std::string& name);

/// Voxels [lo, hi) of a scan.
struct VoxelBox {
    Vec3i lo{0, 0, 0}, hi{0, 0, 0};
    Vec3i size() const { return hi - lo; }
    std::uint64_t voxelCount() const {
        return std::uint64_t(hi.x - lo.x) * std::uint64_t(hi.y - lo.y) * std::uint64_t(hi.z - lo.z);
    }
};

/// "181 x 217 x 181"
std::string sizeText(const Vec3i& size);
/// Bytes as "12.3 MB" (10^6 bytes)
std::string bytesText(double bytes);

} // namespace stf
