// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/shell/shell_sample.h"

#include <cstdint>
#include <vector>

namespace stf {

constexpr int kLeafLog2 = 3, kLeafSize = 1 << kLeafLog2, kLeafRows = kLeafSize * kLeafSize;
constexpr std::uint32_t kNoLeaf = 0xffffffffu;

/// 8^3 voxels, in the order of OpenVDB's leaves (x slowest): which of them have a sample, and where it is.
struct alignas(64) ShellLeaf {
    const ShellSample* samples = nullptr; ///< those of its voxels, in order, without gaps
    std::uint32_t number = 0;             ///< of the first, in the whole grid
    std::uint32_t count = 0;
    std::uint32_t next[8] = {};           ///< leaves of higher coordinates: bit 2 x, bit 1 y, bit 0 z; [0]: this one
    Vec3i origin;                         ///< voxel of lowest coordinates
    std::uint8_t row[kLeafRows] = {};     ///< voxels along z that have a sample, by 8 x + y
    std::uint16_t before[kLeafRows] = {}; ///< samples of the rows before

    static int rowOf(int x, int y) { return x * kLeafSize + y; }
};
static_assert(sizeof(ShellLeaf) == 256);

/// One voxel size of a shell grid. Samples lie in blocks that never move, so that a build needs no second copy of them;
/// leaves are found by a hash of their coordinates, which fits into the cache where a dense table of them would not.
class ShellLevel {
public:
    ShellLevel() = default;
    ShellLevel(ShellLevel&&) noexcept = default;
    ShellLevel& operator=(ShellLevel&&) noexcept = default;

    Vec3d origin; ///< position of voxel (0, 0, 0)'s middle, object space
    double voxel = 0;
    ShellCodec codec;
    std::size_t foldedVoxels = 0;

    /// Adds a leaf with the samples that it counts.
    void add(ShellLeaf leaf, const ShellSample* samples);
    /// After the last leaf: numbers samples from `firstNumber` on and makes leaves findable.
    void finish(std::uint32_t firstNumber);

    /// The leaf of a voxel, or null.
    const ShellLeaf* find(int x, int y, int z) const {
        const std::uint32_t lx = std::uint32_t((x >> kLeafLog2) - lowest_.x),
                            ly = std::uint32_t((y >> kLeafLog2) - lowest_.y),
                            lz = std::uint32_t((z >> kLeafLog2) - lowest_.z);
        if (lx >= extent_[0] || ly >= extent_[1] || lz >= extent_[2]) {
            return nullptr;
        }
        const std::uint64_t key = keyOf(lx, ly, lz);
        for (std::size_t i = slotOf(key);; i = (i + 1) & mask_) {
            const Slot& s = slots_[i];
            if (s.key == key) {
                return &leaves_[s.leaf];
            }
            if (s.leaf == kNoLeaf) {
                return nullptr;
            }
        }
    }
    const std::vector<ShellLeaf>& leaves() const { return leaves_; }
    std::size_t sampleCount() const { return count_; }
    std::size_t memoryBytes() const;
    Vec3d centre(int x, int y, int z) const { return origin + Vec3d(x, y, z) * voxel; }

private:
    struct Slot {
        std::uint64_t key = ~std::uint64_t(0);
        std::uint32_t leaf = kNoLeaf;
    };
    static std::uint64_t keyOf(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        return std::uint64_t(x) << 42 | std::uint64_t(y) << 21 | z;
    }
    std::size_t slotOf(std::uint64_t key) const { return std::size_t(key * 0x9e3779b97f4a7c15u >> shift_); }

    std::vector<std::vector<ShellSample>> blocks_;
    std::vector<ShellLeaf> leaves_;
    std::vector<Slot> slots_;
    std::size_t count_ = 0, mask_ = 0;
    int shift_ = 63;
    Vec3i lowest_;                        ///< leaf coordinates
    std::uint32_t extent_[3] = {0, 0, 0}; ///< in leaves; each below 2^21
};

} // namespace stf
