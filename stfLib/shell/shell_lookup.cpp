// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_grid_impl.h"

// Vectors of eight lanes, one for each corner of a voxel. GCC and Clang make of them what the processor has.
namespace {

typedef float Lanes __attribute__((vector_size(32)));
typedef std::int32_t LanesInt __attribute__((vector_size(32)));
typedef std::uint32_t LanesUint __attribute__((vector_size(32)));
typedef std::int16_t Row __attribute__((vector_size(16)));
typedef float Four __attribute__((vector_size(16)));

constexpr Lanes kCornerX = {0, 0, 0, 0, 1, 1, 1, 1}, kCornerY = {0, 0, 1, 1, 0, 0, 1, 1},
                kCornerZ = {0, 1, 0, 1, 0, 1, 0, 1};
constexpr LanesInt kCornerBit = {1, 2, 4, 8, 16, 32, 64, 128};

/// Rows of eight numbers become columns: out[k] has number k of each row.
inline __attribute__((always_inline)) void transpose(const Row (&in)[8], Row (&out)[8]) {
    Row a[8], b[8];
    for (int i = 0; i < 4; ++i) {
        a[2 * i] = __builtin_shufflevector(in[2 * i], in[2 * i + 1], 0, 8, 1, 9, 2, 10, 3, 11);
        a[2 * i + 1] = __builtin_shufflevector(in[2 * i], in[2 * i + 1], 4, 12, 5, 13, 6, 14, 7, 15);
    }
    for (int i = 0; i < 2; ++i) {
        for (int k = 0; k < 2; ++k) {
            b[4 * i + 2 * k] =
                __builtin_shufflevector(a[4 * i + k], a[4 * i + 2 + k], 0, 1, 8, 9, 2, 3, 10, 11);
            b[4 * i + 2 * k + 1] =
                __builtin_shufflevector(a[4 * i + k], a[4 * i + 2 + k], 4, 5, 12, 13, 6, 7, 14, 15);
        }
    }
    for (int k = 0; k < 4; ++k) {
        out[2 * k] = __builtin_shufflevector(b[k], b[4 + k], 0, 1, 2, 3, 8, 9, 10, 11);
        out[2 * k + 1] = __builtin_shufflevector(b[k], b[4 + k], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

inline __attribute__((always_inline)) Lanes magnitude(const Lanes& v) {
    return (Lanes)((LanesInt)v & 0x7fffffff);
}

inline __attribute__((always_inline)) Lanes select(const LanesInt& mask, const Lanes& v) {
    return (Lanes)(mask & (LanesInt)v);
}

/// See fromHalf.
inline __attribute__((always_inline)) Lanes halves(const Row& v) {
    const LanesInt bits = (__builtin_convertvector(v, LanesInt) << 13) & std::int32_t(0x8fffffffu);
    return (Lanes)bits * 0x1p112f;
}

/// Nearest whole numbers, for |v| < 2^22.
inline __attribute__((always_inline)) Lanes nearest(const Lanes& v) {
    return (v + 12582912.0f) - 12582912.0f;
}

/// Sums over lanes of four vectors.
inline __attribute__((always_inline)) Four sums(const Lanes& a, const Lanes& b, const Lanes& c, const Lanes& d) {
    const auto half = [](const Lanes& v) __attribute__((always_inline)) {
        return __builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7);
    };
    const Four a4 = half(a), b4 = half(b), c4 = half(c), d4 = half(d);
    const Four ab = __builtin_shufflevector(a4, b4, 0, 4, 1, 5) + __builtin_shufflevector(a4, b4, 2, 6, 3, 7);
    const Four cd = __builtin_shufflevector(c4, d4, 0, 4, 1, 5) + __builtin_shufflevector(c4, d4, 2, 6, 3, 7);
    return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

} // namespace

namespace stf {

namespace {

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
    Corners c;
    if (!corners(view, int(floor.x), int(floor.y), int(floor.z), c)) {
        return false;
    }
    const Vec3f f(at - floor);
    const float wx[2] = {1 - f.x, f.x}, wy[2] = {1 - f.y, f.y}, wz[2] = {1 - f.z, f.z};
    const auto weightOf = [&](int i) { return wx[i >> 2] * wy[i >> 1 & 1] * wz[i & 1]; };
    int ref = (f.x > 0.5f ? 4 : 0) | (f.y > 0.5f ? 2 : 0) | (f.z > 0.5f ? 1 : 0);
    if (c.present != 255) {
        float best = c.present >> ref & 1 ? 2.0f : -1.0f;
        for (int i = 0; i < 8; ++i) {
            if (c.present >> i & 1 && weightOf(i) > best) {
                best = weightOf(i);
                ref = i;
            }
        }
        for (int i = 0; i < 8; ++i) { // lanes that do not count must be readable
            c.sample[i] = c.present >> i & 1 ? c.sample[i] : c.sample[ref];
        }
    }

    Row packed[8], column[8];
    for (int i = 0; i < 8; ++i) {
        std::memcpy(&packed[i], c.sample[i], sizeof packed[i]);
    }
    LanesUint placeX, placeY;
    for (int i = 0; i < 8; ++i) {
        placeX[i] = c.sample[i]->x;
        placeY[i] = c.sample[i]->y;
    }
    transpose(packed, column);
    Lanes gradX[3], gradY[3], normal[3];
    for (int a = 0; a < 3; ++a) {
        gradX[a] = halves(column[a]);
        gradY[a] = halves(column[3 + a]);
    }
    {
        Lanes x = __builtin_convertvector(__builtin_convertvector(column[6], LanesInt), Lanes) * (1 / 32767.0f);
        Lanes y = __builtin_convertvector(__builtin_convertvector(column[7], LanesInt), Lanes) * (1 / 32767.0f);
        const Lanes z = 1.0f - magnitude(x) - magnitude(y);
        const Lanes fold = select(z < 0.0f, -z);
        const auto toward = [](const Lanes& v, const Lanes& by) __attribute__((always_inline)) {
            return v - (Lanes)((LanesInt)by | ((LanesInt)v & INT32_MIN)); // by, with the sign of v
        };
        x = toward(x, fold);
        y = toward(y, fold);
        const Lanes squared = x * x + y * y + z * z;
        Lanes scale;
        for (int i = 0; i < 8; ++i) {
            scale[i] = 1 / std::sqrt(squared[i]);
        }
        normal[0] = x * scale;
        normal[1] = y * scale;
        normal[2] = z * scale;
    }
    const Lanes depth = __builtin_convertvector((LanesInt)((placeX & 0xffu) | (placeY & 0xffu) << 8), Lanes) *
                            view.depthStep + view.depthLow;

    // What the reference's gradients foresee at the other corners; integers wrap as the tile does, so that what is
    // left is the difference to the nearest image.
    const float voxel = view.voxelMm;
    const Lanes ox = (kCornerX - float(ref >> 2)) * voxel, oy = (kCornerY - float(ref >> 1 & 1)) * voxel,
                oz = (kCornerZ - float(ref & 1)) * voxel;
    const auto foreseen = [&](const Lanes(&g)[3]) __attribute__((always_inline)) {
        return ox * g[0][ref] + oy * g[1][ref] + oz * g[2][ref];
    };
    const auto deviation = [&](const Lanes& expected, const LanesUint& place, float tile)
        __attribute__((always_inline)) {
        const Lanes turns = expected * (1 / tile);
        const LanesInt whole = __builtin_convertvector((turns - nearest(turns)) * 0x1p32f, LanesInt);
        const LanesUint difference = (place & kFractionBits) - (place[ref] & kFractionBits) - (LanesUint)whole;
        return __builtin_convertvector((LanesInt)difference, Lanes) * (tile * 0x1p-32f);
    };
    const auto tolerance = [&](const Lanes(&g)[3], float tile) {
        // Half a voxel's change is more than curvature brings and less than most jumps.
        const float slope = std::sqrt(g[0][ref] * g[0][ref] + g[1][ref] * g[1][ref] + g[2][ref] * g[2][ref]);
        return std::min(0.25f * tile, 0.5f * slope * voxel + 1e-3f * tile);
    };
    const Lanes expectedX = foreseen(gradX), expectedY = foreseen(gradY);
    const Lanes devX = deviation(expectedX, placeX, tile_.x), devY = deviation(expectedY, placeY, tile_.y);
    const Lanes expectedDepth = depth[ref] - foreseen(normal);
    const Lanes facing = normal[0] * normal[0][ref] + normal[1] * normal[1][ref] + normal[2] * normal[2][ref];
    // Patches differ where the coordinate is not what the reference foresees, sheets of the shell where the depth is
    // not.
    LanesInt same = (kCornerBit & std::int32_t(c.present)) != 0;
    same &= magnitude(devX) <= tolerance(gradX, tile_.x);
    same &= magnitude(devY) <= tolerance(gradY, tile_.y);
    same &= magnitude(depth - expectedDepth) <= voxel;
    same &= facing > 0.0f;
    same[ref] = -1;

    const auto towards = [](const Lanes& corner, float at1) __attribute__((always_inline)) {
        return corner * at1 + (1.0f - corner) * (1.0f - at1);
    };
    Lanes weight = towards(kCornerX, f.x) * towards(kCornerY, f.y) * towards(kCornerZ, f.z);
    // The nearest corner always counts, even where rounding makes its weight zero.
    weight[ref] = std::max(weight[ref], 1e-6f);
    weight = select(same, weight);
    const Lanes sx = (f.x - kCornerX) * voxel, sy = (f.y - kCornerY) * voxel, sz = (f.z - kCornerZ) * voxel;
    const auto step = [&](const Lanes(&g)[3]) __attribute__((always_inline)) {
        return g[0] * sx + g[1] * sy + g[2] * sz;
    };
    bool all = true;
    for (int i = 0; i < 8; ++i) {
        all = all && same[i];
    }
    // With all corners the errors of interpolation and of extrapolation are opposite and equal: their mean is exact to
    // second order. Without some, only extrapolation has no bias.
    const float share = all ? 0.5f : 1.0f, depthShare = all ? 0.0f : 1.0f;
    const Four a = sums(weight, weight * (expectedX + devX + step(gradX) * share),
                        weight * (expectedY + devY + step(gradY) * share), weight * (depth - step(normal) * depthShare));
    const Four gx = sums(weight * gradX[0], weight * gradX[1], weight * gradX[2], weight * normal[0]);
    const Four gy = sums(weight * gradY[0], weight * gradY[1], weight * gradY[2], weight * normal[1]);
    float nz = 0;
    const Lanes weightedZ = weight * normal[2];
    for (int i = 0; i < 8; ++i) {
        nz += weightedZ[i];
    }
    const float scale = 1 / a[0], gradientScale = scale * view.mmPerUnit;
    const ShellSample& reference = *c.sample[ref];
    const auto place = [](std::uint32_t bits, float tile) { return float(bits & kFractionBits) * (tile * 0x1p-32f); };
    out.exemplar = {place(reference.x, tile_.x) + a[1] * scale, place(reference.y, tile_.y) + a[2] * scale};
    out.depth = a[3] * scale;
    out.gradX = Vec3f(gx[0], gx[1], gx[2]) * gradientScale;
    out.gradY = Vec3f(gy[0], gy[1], gy[2]) * gradientScale;
    out.normal = normalize(Vec3f(gx[3], gy[3], nz));
    out.triangle = reference.triangle;
    out.b1 = float(reference.b1) * (1 / 65535.0f);
    out.b2 = float(reference.b2) * (1 / 65535.0f);
    out.coreRadiance = Rgb(0.0f);
    if (core) {
        for (int i = 0; i < 8; ++i) {
            if (same[i]) {
                out.coreRadiance += core[c.number[i]] * (weight[i] * scale);
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
    Corners c;
    if (std::abs(at.x) < 1e9 && std::abs(at.y) < 1e9 && std::abs(at.z) < 1e9 && view.leaf &&
        corners(view, int(quickFloor(at.x)), int(quickFloor(at.y)), int(quickFloor(at.z)), c)) {
        for (int i = 0; i < 8; i += 2) {
            if (c.present >> i & 1) {
                __builtin_prefetch(c.sample[i]);
            }
        }
    }
}

struct ShellGrid::Accessor::Impl : ShellReader {
    using ShellReader::ShellReader;
};

ShellGrid::Accessor::Accessor(const ShellGrid& grid) : impl_(std::make_unique<Impl>(*grid.impl_)) {}
ShellGrid::Accessor::~Accessor() = default;
ShellGrid::Accessor::Accessor(Accessor&&) noexcept = default;

bool ShellGrid::Accessor::lookup(const Vec3f& objectPoint, ShellLookup& out, const Rgb* core, int level) {
    return impl_->lookup(objectPoint, level, out, core);
}

void ShellGrid::Accessor::prefetch(const Vec3f& objectPoint, int level) {
    impl_->prefetch(objectPoint, level);
}

} // namespace stf
