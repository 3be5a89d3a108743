// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_grid_impl.h"

namespace stf {

namespace {

using LevelView = ShellReader::LevelView;

namespace plain {
#include "stfLib/shell/shell_lookup_kernel.inc"
}
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define STF_SHELL_AVX2 1
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#include "stfLib/shell/shell_lookup_kernel.inc"
}
#pragma GCC pop_options
#endif

/// The same numbers by either: nothing is fused, sums have one order.
using AddUp = decltype(&plain::addUp);
AddUp chooseAddUp() {
#if STF_SHELL_AVX2
    if (__builtin_cpu_supports("avx2")) {
        return avx2::addUp;
    }
#endif
    return plain::addUp;
}
const AddUp addUp = chooseAddUp();

/// Samples among the voxels of a row below z: bits of a byte below its z-th.
struct BitCounts {
    std::uint8_t of[256];
    constexpr BitCounts() : of() {
        for (int i = 0; i < 256; ++i) {
            int count = 0;
            for (int b = i; b; b &= b - 1) {
                ++count;
            }
            of[i] = std::uint8_t(count);
        }
    }
};
constexpr BitCounts kBits;

} // namespace

ShellReader::ShellReader(const ShellGridData& grid) : tile_{float(grid.tileMm.x), float(grid.tileMm.y)} {
    for (const ShellLevel& level : grid.levels) {
        LevelView v;
        v.level = &level;
        v.leaf = level.leaves().empty() ? nullptr : &level.leaves().front();
        v.perVoxel = 1 / level.voxel;
        v.mmPerUnit = float(grid.mmPerUnit);
        v.voxelMm = float(level.voxel * grid.mmPerUnit);
        v.depthLow = float(level.codec.depthLow);
        v.depthStep = float(level.codec.depthStep);
        views_.push_back(v);
    }
}

/// The two corners of a row at z and z + 1.
inline void ShellReader::rowOf(const ShellLeaf& leaf, int row, int z, int corner, Corners& out) {
    const unsigned bits = leaf.row[row], here = bits >> z & 1u;
    const unsigned first = leaf.before[row] + kBits.of[bits & ((1u << z) - 1u)];
    out.present |= (bits >> z & 3u) << corner;
    out.sample[corner] = leaf.samples + first;
    out.sample[corner + 1] = leaf.samples + first + here;
    out.number[corner] = leaf.number + first;
    out.number[corner + 1] = leaf.number + first + here;
}

bool ShellReader::corners(LevelView& view, int x, int y, int z, Corners& out) const {
    constexpr int mask = kLeafSize - 1;
    const ShellLevel& level = *view.level;
    const ShellLeaf* leaf = view.leaf;
    if (((x ^ leaf->origin.x) | (y ^ leaf->origin.y) | (z ^ leaf->origin.z)) & ~mask) {
        leaf = level.find(x, y, z);
        if (leaf) {
            view.leaf = leaf;
        }
    }
    const int lx = x & mask, ly = y & mask, lz = z & mask;
    if (leaf && lx != mask && ly != mask && lz != mask) {
        const int row = ShellLeaf::rowOf(lx, ly);
        rowOf(*leaf, row, lz, 0, out);
        rowOf(*leaf, row + 1, lz, 2, out);
        rowOf(*leaf, row + kLeafSize, lz, 4, out);
        rowOf(*leaf, row + kLeafSize + 1, lz, 6, out);
        return out.present != 0;
    }
    const ShellLeaf* const leaves = level.leaves().data();
    for (int c = 0; c < 8; ++c) {
        const int cx = lx + (c >> 2), cy = ly + (c >> 1 & 1), cz = lz + (c & 1);
        const int beyond = cx >> kLeafLog2 << 2 | cy >> kLeafLog2 << 1 | cz >> kLeafLog2;
        const ShellLeaf* owner = nullptr;
        if (leaf) {
            const std::uint32_t next = leaf->next[beyond];
            owner = next == kNoLeaf ? nullptr : leaves + next;
        } else {
            owner = level.find(x + (c >> 2), y + (c >> 1 & 1), z + (c & 1));
        }
        if (!owner) {
            continue;
        }
        const int row = ShellLeaf::rowOf(cx & mask, cy & mask);
        const unsigned bits = owner->row[row], bit = unsigned(cz & mask);
        if (bits >> bit & 1u) {
            const unsigned at = owner->before[row] + kBits.of[bits & ((1u << bit) - 1u)];
            out.sample[c] = owner->samples + at;
            out.number[c] = owner->number + at;
            out.present |= 1u << c;
        }
    }
    return out.present != 0;
}

int ShellReader::addUpFrom(const LevelView& view, const Corners& c, int ref, const Vec3f& f, ShellLookup& out,
                           float (&weights)[8]) const {
    const ShellSample* lane[8];
    unsigned present = 255;
    for (int i = 0; i < 8; ++i) {
        lane[i] = c.sample[i ^ ref];
    }
    if (c.present != 255) {
        present = 0;
        for (int i = 0; i < 8; ++i) { // lanes that do not count must be readable
            const bool there = c.present >> (i ^ ref) & 1;
            present |= unsigned(there) << i;
            lane[i] = there ? lane[i] : c.sample[ref];
        }
    }
    return addUp(view, tile_, lane, present, ref, f, prefer_, out, weights);
}

bool ShellReader::lookup(const Vec3f& objectPoint, int levelNumber, ShellLookup& out, const Rgb* core) {
    if (views_.empty()) {
        return false;
    }
    LevelView& view = views_[std::size_t(std::clamp(levelNumber, 0, int(views_.size()) - 1))];
    const Vec3d at = (Vec3d(objectPoint) - view.level->origin) * view.perVoxel;
    // Also false for NaN and for an empty grid.
    if (!(std::abs(at.x) < 1e9 && std::abs(at.y) < 1e9 && std::abs(at.z) < 1e9) || !view.leaf) {
        return false;
    }
    const Vec3d floor(quickFloor(at.x), quickFloor(at.y), quickFloor(at.z));
    const int x = int(floor.x), y = int(floor.y), z = int(floor.z);
    Corners own;
    const Ahead* const known = ahead_[0].is(view, x, y, z)   ? &ahead_[0]
                               : ahead_[1].is(view, x, y, z) ? &ahead_[1]
                                                             : nullptr;
    if (!(known ? known->found : corners(view, x, y, z, own))) {
        return false;
    }
    const Corners& c = known ? known->corners : own;
    const Vec3f f(at - floor);
    int ref = (f.x > 0.5f ? 4 : 0) | (f.y > 0.5f ? 2 : 0) | (f.z > 0.5f ? 1 : 0);
    if (!(c.present >> ref & 1)) {
        // The nearest of those there are.
        float best = -1;
        for (int i = 0; i < 8; ++i) {
            const float weight = (i & 4 ? f.x : 1 - f.x) * (i & 2 ? f.y : 1 - f.y) * (i & 1 ? f.z : 1 - f.z);
            if (c.present >> i & 1 && weight > best) {
                best = weight;
                ref = i;
            }
        }
    }
    float weights[8];
    if (const int better = addUpFrom(view, c, ref, f, out, weights)) {
        ref ^= better;
        addUpFrom(view, c, ref, f, out, weights);
    }
    const ShellSample& reference = *c.sample[ref];
    out.triangle = reference.triangle;
    out.b1 = float(reference.b1) * (1 / 65535.0f);
    out.b2 = float(reference.b2) * (1 / 65535.0f);
    out.coreRadiance = Rgb(0.0f);
    if (core) {
        for (int i = 0; i < 8; ++i) {
            if (weights[i] > 0) {
                out.coreRadiance += core[c.number[i ^ ref]] * weights[i];
            }
        }
    }
    return true;
}

void ShellReader::prefetch(const Vec3f& objectPoint, int levelNumber) {
    if (views_.empty()) {
        return;
    }
    LevelView& view = views_[std::size_t(std::clamp(levelNumber, 0, int(views_.size()) - 1))];
    const Vec3d at = (Vec3d(objectPoint) - view.level->origin) * view.perVoxel;
    if (!(std::abs(at.x) < 1e9 && std::abs(at.y) < 1e9 && std::abs(at.z) < 1e9 && view.leaf)) {
        return;
    }
    Ahead& a = ahead_[nextAhead_ ^= 1];
    a.view = &view;
    a.x = int(quickFloor(at.x));
    a.y = int(quickFloor(at.y));
    a.z = int(quickFloor(at.z));
    a.corners.present = 0;
    a.found = corners(view, a.x, a.y, a.z, a.corners);
    // Two samples share a line of the cache, but those of a row may lie in two.
    for (int i = 0; i < 8; ++i) {
        if (a.corners.present >> i & 1) {
            __builtin_prefetch(a.corners.sample[i]);
        }
    }
}

struct ShellGrid::Accessor::Impl : ShellReader {
    using ShellReader::ShellReader;
};

ShellGrid::Accessor::Accessor(const ShellGrid& grid) : impl_(std::make_unique<Impl>(*grid.impl_)) {}
ShellGrid::Accessor::~Accessor() = default;
ShellGrid::Accessor::Accessor(Accessor&&) noexcept = default;

void ShellGrid::Accessor::prefer(const Vec3f& normal) {
    impl_->prefer(normal);
}

bool ShellGrid::Accessor::lookup(const Vec3f& objectPoint, ShellLookup& out, const Rgb* core, int level) {
    return impl_->lookup(objectPoint, level, out, core);
}

void ShellGrid::Accessor::prefetch(const Vec3f& objectPoint, int level) {
    impl_->prefetch(objectPoint, level);
}

} // namespace stf
