// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_grid_impl.h"

#include "stfLib/base/parallel.h"
#include "stfLib/shell/shell_prism.h"

#include <atomic>
#include <tbb/parallel_sort.h>

namespace stf {

namespace {

// Space is cut into bricks of 2 x 2 x 2 leaves; each is filled by one thread from the prisms that may reach it.
constexpr int brickLog2 = 4, brickSize = 1 << brickLog2, brickVoxels = brickSize * brickSize * brickSize;
constexpr int leafLog2 = 3, leafSize = 1 << leafLog2, leafVoxels = leafSize * leafSize * leafSize;
using Leaf = openvdb::Int32Tree::LeafNodeType;
static_assert(Leaf::DIM == leafSize, "bricks are made of the tree's leaves");

// A lookup on either boundary has corners up to a voxel's diagonal beyond it.
constexpr double margin = 1.8;

/// Brick coordinates relative to the lowest, packed; 21 bits each.
struct BrickTriangle {
    std::uint64_t brick;
    std::uint32_t triangle;
    bool operator<(const BrickTriangle& o) const { return brick != o.brick ? brick < o.brick : triangle < o.triangle; }
};

std::uint64_t packBrick(const Vec3i& b) {
    return std::uint64_t(b.x) << 42 | std::uint64_t(b.y) << 21 | std::uint64_t(b.z);
}

Vec3i unpackBrick(std::uint64_t key) {
    return {int(key >> 42), int(key >> 21 & 0x1fffff), int(key & 0x1fffff)};
}

/// Voxels whose centres a prism may hold.
struct VoxelBox {
    Vec3i lo, hi;
};

/// Best claim on a voxel so far.
struct Claim {
    float b1, b2, depth;
    std::int32_t triangle; ///< -1: none
};

struct Brick {
    std::uint64_t key;
    std::size_t begin, end; ///< its triangles in the sorted list
    std::vector<ShellSample> samples;
    std::vector<std::unique_ptr<Leaf>> leaves; ///< values count from the brick's first sample
};

class Scanner {
public:
    Scanner(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map, ShellGridData& grid,
            Progress& progress)
        : surface_(surface), boundary_(boundary), map_(map), grid_(grid), progress_(progress),
          outside_(margin * grid.voxel) {}

    void run(const MessageSink& messages);

private:
    VoxelBox voxelBox(const ShellPrism& prism) const;
    void findLowestBrick();
    void listBricks();
    void emitBricks(const ShellPrism& prism, Vec3i lo, Vec3i hi, std::uint32_t triangle,
                    std::vector<BrickTriangle>& out) const;
    void fillBrick(Brick& brick, std::vector<Claim>& claims);
    void claim(const ShellPrism& prism, std::int32_t triangle, const Vec3i& corner, std::vector<Claim>& claims);
    void makeSamples(Brick& brick, const Vec3i& corner, const std::vector<Claim>& claims);
    ShellSample makeSample(const Claim& claim) const;
    void collect();

    const RefinedSurface& surface_;
    const ShellBoundary& boundary_;
    const ExemplarMap& map_;
    ShellGridData& grid_;
    Progress& progress_;
    double outside_; ///< object units beyond both boundaries
    Vec3i lowest_;   ///< brick with the lowest coordinates
    std::vector<BrickTriangle> pairs_;
    std::vector<Brick> bricks_;
    std::atomic<std::size_t> folded_{0}, unusable_{0};
};

VoxelBox Scanner::voxelBox(const ShellPrism& prism) const {
    Vec3d lo(1e300), hi(-1e300);
    const double deep = prism.largestThickness() + outside_;
    for (int c = 0; c < 3; ++c) {
        for (double d : {-outside_, deep}) {
            const Vec3d p = (prism.corner(c, d) - grid_.origin) / grid_.voxel;
            lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
            hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
        }
    }
    // Rounding on the side faces must not lose a voxel.
    const double slack = 1e-3;
    return {{int(std::ceil(lo.x - slack)), int(std::ceil(lo.y - slack)), int(std::ceil(lo.z - slack))},
            {int(std::floor(hi.x + slack)), int(std::floor(hi.y + slack)), int(std::floor(hi.z + slack))}};
}

void Scanner::findLowestBrick() {
    // Prisms reach beyond the bounds by at most their thickness and the margin, if directions turn outward.
    float thickest = 0;
    for (float t : boundary_.thickness) {
        thickest = std::max(thickest, t);
    }
    const double reach = (double(thickest) + outside_) * 1.05 + 2 * grid_.voxel;
    const Vec3d lo = (Vec3d(surface_.bounds.lo) - Vec3d(reach) - grid_.origin) / grid_.voxel;
    const Vec3d hi = (Vec3d(surface_.bounds.hi) + Vec3d(reach) - grid_.origin) / grid_.voxel;
    if (maxComponent(hi - lo) > double(1 << 24)) {
        throw Error("the shell is too thin for the size of the object: its grid would have more than 16 million voxels "
                    "along an axis");
    }
    lowest_ = {int(std::floor(lo.x)) >> brickLog2, int(std::floor(lo.y)) >> brickLog2,
               int(std::floor(lo.z)) >> brickLog2};
}

void Scanner::emitBricks(const ShellPrism& prism, Vec3i lo, Vec3i hi, std::uint32_t triangle,
                         std::vector<BrickTriangle>& out) const {
    const Vec3i count = hi - lo + Vec3i(1);
    if (prism.facetLo > 0) {
        // Whole blocks beside the slab around the triangle are left out: large triangles have large empty boxes.
        const Vec3d half = Vec3d(count) * (0.5 * brickSize * grid_.voxel);
        const Vec3d centre = grid_.origin + Vec3d(lo) * (brickSize * grid_.voxel) + half;
        const double below = -dot(centre - prism.p0, prism.facet);
        const double radius = std::abs(half.x * prism.facet.x) + std::abs(half.y * prism.facet.y) +
                              std::abs(half.z * prism.facet.z) + grid_.voxel;
        if (below + radius < -outside_ * prism.facetHi ||
            below - radius > (prism.largestThickness() + outside_) * prism.facetHi) {
            return;
        }
    }
    const int longest = maxComponent(count);
    if (longest == 1) {
        out.push_back({packBrick(lo - lowest_), triangle});
        return;
    }
    const int axis = count.x == longest ? 0 : count.y == longest ? 1 : 2;
    Vec3i middle = hi;
    middle[axis] = lo[axis] + longest / 2 - 1;
    emitBricks(prism, lo, middle, triangle, out);
    Vec3i next = lo;
    next[axis] = middle[axis] + 1;
    emitBricks(prism, next, hi, triangle, out);
}

void Scanner::listBricks() {
    const std::size_t grain = 4096, count = surface_.triangles.size();
    std::vector<std::vector<BrickTriangle>> chunks((count + grain - 1) / grain);
    parallelFor(count, grain, [&](std::size_t begin, std::size_t end) {
        std::vector<BrickTriangle>& out = chunks[begin / grain];
        ShellPrism prism;
        for (std::size_t t = begin; t < end; ++t) {
            if (!prism.set(surface_, boundary_, t)) {
                ++unusable_;
                continue;
            }
            const VoxelBox box = voxelBox(prism);
            if (box.lo.x > box.hi.x || box.lo.y > box.hi.y || box.lo.z > box.hi.z) {
                continue;
            }
            const auto brickOf = [](const Vec3i& v) {
                return Vec3i(v.x >> brickLog2, v.y >> brickLog2, v.z >> brickLog2);
            };
            emitBricks(prism, brickOf(box.lo), brickOf(box.hi), std::uint32_t(t), out);
        }
        progress_.update("shell grid", 0.1 * double(begin) / double(count));
    });
    std::size_t total = 0;
    for (const auto& c : chunks) {
        total += c.size();
    }
    pairs_.reserve(total);
    for (auto& c : chunks) {
        pairs_.insert(pairs_.end(), c.begin(), c.end());
        std::vector<BrickTriangle>().swap(c);
    }
    // Pairs are unique, so the order does not depend on how the sort is divided.
    tbb::parallel_sort(pairs_.begin(), pairs_.end());
    for (std::size_t i = 0; i < pairs_.size();) {
        std::size_t end = i + 1;
        while (end < pairs_.size() && pairs_[end].brick == pairs_[i].brick) {
            ++end;
        }
        bricks_.push_back({pairs_[i].brick, i, end, {}, {}});
        i = end;
    }
}

void Scanner::claim(const ShellPrism& prism, std::int32_t triangle, const Vec3i& corner, std::vector<Claim>& claims) {
    VoxelBox box = voxelBox(prism);
    for (int a = 0; a < 3; ++a) {
        box.lo[a] = std::max(box.lo[a], corner[a]);
        box.hi[a] = std::min(box.hi[a], corner[a] + brickSize - 1);
    }
    // Depth below the facet's plane is d (direction . facet): bounds of it, and its slope along a row.
    const bool slab = prism.facetLo > 0;
    const double slack = 1e-3 * grid_.voxel;
    const double lo = -outside_ * prism.facetHi - slack;
    const double hi = (prism.largestThickness() + outside_) * prism.facetHi + slack;
    const double slope = -prism.facet.z * grid_.voxel;
    for (int x = box.lo.x; x <= box.hi.x; ++x) {
        for (int y = box.lo.y; y <= box.hi.y; ++y) {
            int first = box.lo.z, last = box.hi.z;
            const Vec3d row = grid_.centre(x, y, 0) - prism.p0;
            const double below0 = -dot(row, prism.facet);
            if (slab) {
                if (std::abs(slope) > 1e-6 * grid_.voxel) {
                    const double a = (lo - below0) / slope, b = (hi - below0) / slope;
                    first = std::max(first, int(std::ceil(std::clamp(std::min(a, b), -1e9, 1e9))));
                    last = std::min(last, int(std::floor(std::clamp(std::max(a, b), -1e9, 1e9))));
                } else if (below0 + slope * first < lo - slack || below0 + slope * first > hi + slack) {
                    continue;
                }
            }
            Claim* claimRow = claims.data() + (std::size_t(x - corner.x) << (2 * brickLog2)) +
                              (std::size_t(y - corner.y) << brickLog2);
            for (int z = first; z <= last; ++z) {
                Claim& best = claimRow[z - corner.z];
                const double below = below0 + slope * z;
                // No point of this prism can be nearer to its triangle than that.
                if (best.triangle >= 0 && slab && std::abs(below) > std::abs(double(best.depth)) * prism.facetHi) {
                    continue;
                }
                ShellPrism::Point point;
                if (!prism.invert(row + Vec3d(0, 0, z * grid_.voxel), outside_, outside_, point)) {
                    continue;
                }
                if (best.triangle < 0 || std::abs(float(point.d)) < std::abs(best.depth)) {
                    best = {float(point.b1), float(point.b2), float(point.d), triangle};
                }
            }
        }
    }
}

ShellSample Scanner::makeSample(const Claim& claim) const {
    const std::size_t t = std::size_t(claim.triangle);
    const Vec3i& tri = surface_.triangles[t];
    const double b[3] = {1.0 - double(claim.b1) - double(claim.b2), double(claim.b1), double(claim.b2)};
    double x = 0, y = 0;
    Vec3d normal, gradient[2];
    for (int c = 0; c < 3; ++c) {
        const std::size_t i = 3 * t + std::size_t(c);
        x += b[c] * double(map_.cornerCoords[i].x);
        y += b[c] * double(map_.cornerCoords[i].y);
        normal += Vec3d(surface_.normals[std::size_t(tri[c])]) * b[c];
        gradient[0] += Vec3d(map_.gradientX[i]) * b[c];
        gradient[1] += Vec3d(map_.gradientY[i]) * b[c];
    }
    normal = normalize(normal);
    ShellPrism prism;
    prism.set(surface_, boundary_, t);
    const ShellPrism::Point point{b[1], b[2], double(claim.depth), false};
    for (Vec3d& g : gradient) {
        // The smooth gradient is tangent to the limit surface. Brought into the triangle's plane along the normal it
        // gives the slopes over the triangle, and by the prism's map the gradient at this depth.
        const double along = dot(normal, prism.facet);
        const Vec3d flat = along > 0.1 ? g - normal * (dot(g, prism.facet) / along) : g;
        Vec3d deep;
        // At a focus the map has no inverse; the surface's gradient is at least of the right kind.
        if (prism.gradient(point, dot(flat, prism.e1), dot(flat, prism.e2), deep) && dot(deep, deep) < 64 * dot(g, g)) {
            g = deep;
        }
    }
    ShellSample sample{};
    const auto wrapped = [](double v, double tile) { return float(v - std::floor(v / tile) * tile); };
    sample.exemplar = {wrapped(x, grid_.tileMm.x), wrapped(y, grid_.tileMm.y)};
    sample.depth = float(double(claim.depth) * grid_.mmPerUnit);
    sample.gradX = Vec3f(gradient[0]);
    sample.gradY = Vec3f(gradient[1]);
    // A faceted surface is shaded by its facets; its shared normals only say where the shell lies.
    Vec3d shading = normal;
    if (!surface_.cornerNormals.empty()) {
        shading = Vec3d(0.0);
        for (std::size_t c = 0; c < 3; ++c) {
            shading += Vec3d(surface_.cornerNormals[3 * t + c]) * b[c];
        }
    }
    sample.normal = Vec3f(normalize(shading));
    sample.triangle = std::uint32_t(claim.triangle);
    sample.b1 = std::uint16_t(std::lround(claim.b1 * 65535.0f));
    sample.b2 = std::uint16_t(std::lround(claim.b2 * 65535.0f));
    return sample;
}

void Scanner::makeSamples(Brick& brick, const Vec3i& corner, const std::vector<Claim>& claims) {
    const int leavesPerAxis = brickSize / leafSize;
    for (int l = 0; l < leavesPerAxis * leavesPerAxis * leavesPerAxis; ++l) {
        const Vec3i at(l / 4 * leafSize, l / 2 % 2 * leafSize, l % 2 * leafSize);
        std::unique_ptr<Leaf> leaf;
        for (int v = 0; v < leafVoxels; ++v) {
            const int x = at.x + (v >> (2 * leafLog2)), y = at.y + (v >> leafLog2 & (leafSize - 1)),
                      z = at.z + (v & (leafSize - 1));
            const Claim& best =
                claims[(std::size_t(x) << (2 * brickLog2)) + (std::size_t(y) << brickLog2) + std::size_t(z)];
            if (best.triangle < 0) {
                continue;
            }
            if (!leaf) {
                leaf = std::make_unique<Leaf>(openvdb::Coord(corner.x + at.x, corner.y + at.y, corner.z + at.z), -1,
                                              false);
            }
            const ShellSample sample = makeSample(best);
            if (!isFinite(sample.normal) || !isFinite(sample.gradX) || !isFinite(sample.gradY) ||
                !std::isfinite(sample.exemplar.x) || !std::isfinite(sample.exemplar.y)) {
                continue;
            }
            leaf->setValueOn(openvdb::Index(v), std::int32_t(brick.samples.size()));
            brick.samples.push_back(sample);
        }
        if (leaf && !leaf->isEmpty()) {
            brick.leaves.push_back(std::move(leaf));
        }
    }
}

void Scanner::fillBrick(Brick& brick, std::vector<Claim>& claims) {
    claims.assign(brickVoxels, Claim{0, 0, 0, -1});
    const Vec3i b = unpackBrick(brick.key) + lowest_;
    const Vec3i corner(b.x * brickSize, b.y * brickSize, b.z * brickSize);
    ShellPrism prism;
    for (std::size_t i = brick.begin; i < brick.end; ++i) {
        if (prism.set(surface_, boundary_, pairs_[i].triangle)) {
            claim(prism, std::int32_t(pairs_[i].triangle), corner, claims);
        }
    }
    std::size_t folded = 0;
    for (const Claim& c : claims) {
        if (c.triangle >= 0 && c.depth > 0 && prism.set(surface_, boundary_, std::size_t(c.triangle)) &&
            double(c.depth) < prism.thickness(double(c.b1), double(c.b2))) {
            const double d = double(c.depth);
            folded += dot(cross(prism.e1 - prism.m1 * d, prism.e2 - prism.m2 * d),
                          prism.direction(double(c.b1), double(c.b2))) < 0;
        }
    }
    folded_ += folded;
    makeSamples(brick, corner, claims);
}

void Scanner::collect() {
    std::size_t total = 0;
    for (const Brick& b : bricks_) {
        total += b.samples.size();
    }
    if (total > std::size_t(INT32_MAX)) {
        throw Error("the shell has more than 2^31 voxels");
    }
    grid_.samples.reserve(total);
    for (Brick& b : bricks_) {
        const std::int32_t first = std::int32_t(grid_.samples.size());
        grid_.samples.insert(grid_.samples.end(), b.samples.begin(), b.samples.end());
        for (std::unique_ptr<Leaf>& leaf : b.leaves) {
            for (auto it = leaf->beginValueOn(); it; ++it) {
                it.setValue(*it + first);
            }
            grid_.tree.addLeaf(leaf.release());
        }
        b = Brick{};
    }
}

void Scanner::run(const MessageSink& messages) {
    progress_.update("shell grid", 0);
    findLowestBrick();
    listBricks();
    std::atomic<std::size_t> done{0};
    parallelFor(bricks_.size(), 8, [&](std::size_t begin, std::size_t end) {
        std::vector<Claim> claims;
        for (std::size_t i = begin; i < end; ++i) {
            fillBrick(bricks_[i], claims);
        }
        progress_.update("shell grid", 0.1 + 0.85 * double(done += end - begin) / double(bricks_.size()));
    });
    collect();
    progress_.update("shell grid", 1);
    if (unusable_) {
        report(messages, Severity::Warning, std::to_string(unusable_) + " triangles without area have no shell");
    }
    if (folded_) {
        report(messages, Severity::Warning,
               "the shell folds over in " + std::to_string(folded_) + " of " + std::to_string(grid_.samples.size()) +
                   " voxels: it is thicker than the surface's curvature allows");
    }
}

} // namespace

void scanShell(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map,
               ShellGridData& grid, Progress& progress, const MessageSink& messages) {
    Scanner(surface, boundary, map, grid, progress).run(messages);
}

} // namespace stf
