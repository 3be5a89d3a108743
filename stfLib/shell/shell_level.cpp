// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_level.h"

#include "stfLib/base/error.h"
#include "stfLib/base/parallel.h"

namespace stf {

namespace {
constexpr std::size_t kLeastBlock = 4096, kLargestBlock = std::size_t(1) << 20; ///< samples
}

void ShellLevel::add(ShellLeaf leaf, const ShellSample* samples) {
    if (blocks_.empty() || blocks_.back().size() + leaf.count > blocks_.back().capacity()) {
        blocks_.emplace_back();
        // At most a quarter is empty in the end.
        blocks_.back().reserve(std::clamp(count_ / 4, kLeastBlock, kLargestBlock));
    }
    std::vector<ShellSample>& block = blocks_.back();
    leaf.samples = block.data() + block.size();
    block.insert(block.end(), samples, samples + leaf.count);
    leaf.number = std::uint32_t(count_);
    count_ += leaf.count;
    leaves_.push_back(leaf);
}

void ShellLevel::finish(std::uint32_t firstNumber) {
    leaves_.shrink_to_fit();
    if (leaves_.empty()) {
        return;
    }
    Vec3i lo(INT32_MAX), hi(INT32_MIN);
    for (const ShellLeaf& l : leaves_) {
        for (int a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], l.origin[a] >> kLeafLog2);
            hi[a] = std::max(hi[a], l.origin[a] >> kLeafLog2);
        }
    }
    lowest_ = lo;
    for (int a = 0; a < 3; ++a) {
        extent_[a] = std::uint32_t(hi[a] - lo[a]) + 1;
        if (extent_[a] >= 1u << 21) {
            throw Error("the shell grid has more than 16 million voxels along an axis");
        }
    }
    int log2 = 1;
    while ((std::size_t(1) << log2) < 2 * leaves_.size()) {
        ++log2;
    }
    shift_ = 64 - log2;
    mask_ = (std::size_t(1) << log2) - 1;
    slots_.assign(mask_ + 1, Slot{});
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
        const Vec3i& o = leaves_[i].origin;
        const std::uint64_t key =
            keyOf(std::uint32_t((o.x >> kLeafLog2) - lo.x), std::uint32_t((o.y >> kLeafLog2) - lo.y),
                  std::uint32_t((o.z >> kLeafLog2) - lo.z));
        std::size_t slot = slotOf(key);
        while (slots_[slot].leaf != kNoLeaf) {
            slot = (slot + 1) & mask_;
        }
        slots_[slot] = {key, std::uint32_t(i)};
    }
    parallelFor(leaves_.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            ShellLeaf& leaf = leaves_[i];
            leaf.number += firstNumber;
            for (int n = 0; n < 8; ++n) {
                const ShellLeaf* next =
                    find(leaf.origin.x + (n >> 2 & 1) * kLeafSize, leaf.origin.y + (n >> 1 & 1) * kLeafSize,
                         leaf.origin.z + (n & 1) * kLeafSize);
                leaf.next[n] = next ? std::uint32_t(next - leaves_.data()) : kNoLeaf;
            }
        }
    });
}

std::size_t ShellLevel::memoryBytes() const {
    std::size_t bytes = leaves_.capacity() * sizeof(ShellLeaf) + slots_.capacity() * sizeof(Slot);
    for (const auto& b : blocks_) {
        bytes += b.capacity() * sizeof(ShellSample);
    }
    return bytes;
}

} // namespace stf
