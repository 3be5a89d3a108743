// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_scan.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/parallel_sort.h"
#include "stfLib/shell/shell_prism.h"

#include <atomic>

namespace stf {

namespace {

// Space is cut into bricks of 2 x 2 x 2 leaves; each is filled by one thread from the prisms that may reach it.
constexpr int brickLog2 = 4, brickSize = 1 << brickLog2, brickVoxels = brickSize * brickSize * brickSize;
constexpr int leavesPerAxis = brickSize / kLeafSize, leafVoxels = kLeafSize * kLeafSize * kLeafSize;

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
    bool folded;           ///< inside the shell, and inside out
};

/// A half-space that holds a prism: points x, relative to its first corner, with out . x <= bound.
struct Side {
    Vec3d out;
    double bound;
};

/// Slab and sides of a prism, to find the part of a row of voxels that it may hold.
class Sides {
public:
    Sides(const ShellPrism& prism, double outside, double slack) {
        const double deep = prism.largestThickness() + outside;
        Vec3d corner[6];
        for (int c = 0; c < 3; ++c) {
            corner[c] = prism.corner(c, -outside) - prism.p0;
            corner[3 + c] = prism.corner(c, deep) - prism.p0;
        }
        const Vec3d along = prism.direction(1.0 / 3, 1.0 / 3);
        const Vec3d edge[3] = {prism.e1, prism.e2 - prism.e1, -prism.e2};
        if (prism.facetLo > 0) {
            add(-prism.facet, corner, slack);
            add(prism.facet, corner, slack);
        }
        for (const Vec3d& e : edge) {
            const Vec3d out = normalize(cross(e, along));
            if (dot(out, out) > 0.5) {
                add(out, corner, slack + 1e-3 * length(e));
            }
        }
    }

    /// Narrows [first, last], numbers of voxels `step` apart along z, of the row whose number 0 lies at `row`.
    void clip(const Vec3d& row, double step, int& first, int& last) const {
        for (int i = 0; i < count_; ++i) {
            const double room = side_[i].bound - dot(side_[i].out, row), rise = side_[i].out.z * step;
            if (rise > 1e-9 * step) {
                last = std::min(last, int(std::floor(std::clamp(room / rise, -1e9, 1e9))));
            } else if (rise < -1e-9 * step) {
                first = std::max(first, int(std::ceil(std::clamp(room / rise, -1e9, 1e9))));
            } else if (room < 0) {
                last = first - 1;
            }
        }
    }

private:
    void add(const Vec3d& out, const Vec3d (&corner)[6], double slack) {
        double bound = -1e300;
        for (const Vec3d& c : corner) {
            bound = std::max(bound, dot(out, c));
        }
        side_[count_++] = {out, bound + slack};
    }

    Side side_[5];
    int count_ = 0;
};

struct Brick {
    std::uint64_t key;
    std::size_t begin, end; ///< its triangles in the sorted list
    std::vector<ShellSample> samples;
    std::vector<ShellLeaf> leaves; ///< in the order of their samples
};

class Scanner {
public:
    Scanner(const ShellSource& source, ShellLevel& level, const std::function<void(double)>& progress)
        : source_(source), surface_(source.surface), boundary_(source.boundary), map_(source.map), level_(level),
          progress_(progress), outside_(kShellMargin * level.voxel) {}

    ScanCounts run();

private:
    VoxelBox voxelBox(const ShellPrism& prism) const;
    void findLowestBrick();
    void listBricks();
    void emitBricks(const ShellPrism& prism, Vec3i lo, Vec3i hi, std::uint32_t triangle,
                    std::vector<BrickTriangle>& out) const;
    void fillBrick(Brick& brick, std::vector<Claim>& claims);
    void claim(const ShellPrism& prism, std::int32_t triangle, const Vec3i& corner, std::vector<Claim>& claims);
    void makeSamples(Brick& brick, const Vec3i& corner, const std::vector<Claim>& claims);

    const ShellSource& source_;
    const RefinedSurface& surface_;
    const ShellBoundary& boundary_;
    const ExemplarMap& map_;
    ShellLevel& level_;
    const std::function<void(double)>& progress_;
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
            const Vec3d p = (prism.corner(c, d) - level_.origin) / level_.voxel;
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
    // Prisms reach beyond the bounds by their thickness and the margin, along directions of a length below 3.
    float thickest = 0;
    for (float t : boundary_.thickness) {
        thickest = std::max(thickest, t);
    }
    const double reach = (double(thickest) + outside_) * 3 + 2 * level_.voxel;
    const Vec3d lo = (Vec3d(surface_.bounds.lo) - Vec3d(reach) - level_.origin) / level_.voxel;
    const Vec3d hi = (Vec3d(surface_.bounds.hi) + Vec3d(reach) - level_.origin) / level_.voxel;
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
        const Vec3d half = Vec3d(count) * (0.5 * brickSize * level_.voxel);
        const Vec3d centre = level_.origin + Vec3d(lo) * (brickSize * level_.voxel) + half;
        const double below = -dot(centre - prism.p0, prism.facet);
        const double radius = std::abs(half.x * prism.facet.x) + std::abs(half.y * prism.facet.y) +
                              std::abs(half.z * prism.facet.z) + level_.voxel;
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
        progress_(0.1 * double(begin) / double(count));
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
    parallelSort(pairs_.begin(), pairs_.end());
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
    const Sides sides(prism, outside_, 1e-3 * level_.voxel);
    // Depth below the facet's plane is d (direction . facet).
    const bool slab = prism.facetLo > 0;
    const double slope = -prism.facet.z * level_.voxel;
    for (int x = box.lo.x; x <= box.hi.x; ++x) {
        for (int y = box.lo.y; y <= box.hi.y; ++y) {
            int first = box.lo.z, last = box.hi.z;
            const Vec3d row = level_.centre(x, y, 0) - prism.p0;
            sides.clip(row, level_.voxel, first, last);
            const double below0 = -dot(row, prism.facet);
            Claim* claimRow = claims.data() + (std::size_t(x - corner.x) << (2 * brickLog2)) +
                              (std::size_t(y - corner.y) << brickLog2);
            for (int z = first; z <= last; ++z) {
                Claim& best = claimRow[z - corner.z];
                // No point of this prism can be nearer to its triangle than that.
                if (best.triangle >= 0 && slab &&
                    std::abs(below0 + slope * z) > std::abs(double(best.depth)) * prism.facetHi) {
                    continue;
                }
                ShellPrism::Point point;
                if (!prism.invert(row + Vec3d(0, 0, z * level_.voxel), outside_, outside_, point)) {
                    continue;
                }
                if (best.triangle < 0 || std::abs(float(point.d)) < std::abs(best.depth)) {
                    const bool folded = point.folded && point.d > 0 && point.d < prism.thickness(point.b1, point.b2);
                    best = {float(point.b1), float(point.b2), float(point.d), triangle, folded};
                }
            }
        }
    }
}

void Scanner::makeSamples(Brick& brick, const Vec3i& corner, const std::vector<Claim>& claims) {
    for (int l = 0; l < leavesPerAxis * leavesPerAxis * leavesPerAxis; ++l) {
        const Vec3i at(l / 4 * kLeafSize, l / 2 % 2 * kLeafSize, l % 2 * kLeafSize);
        ShellLeaf leaf;
        leaf.origin = corner + at;
        for (int v = 0; v < leafVoxels; ++v) {
            const int x = v / kLeafRows, y = v / kLeafSize % kLeafSize, z = v % kLeafSize;
            const int row = ShellLeaf::rowOf(x, y);
            if (z == 0) {
                leaf.before[row] = std::uint16_t(leaf.count);
            }
            const Claim& best = claims[(std::size_t(at.x + x) << (2 * brickLog2)) +
                                       (std::size_t(at.y + y) << brickLog2) + std::size_t(at.z + z)];
            if (best.triangle < 0) {
                continue;
            }
            const ShellPoint point =
                shellPoint(source_, std::size_t(best.triangle), double(best.b1), double(best.b2), double(best.depth));
            if (!isFinite(point.normal) || !isFinite(point.gradX) || !isFinite(point.gradY) ||
                !std::isfinite(point.exemplar.x) || !std::isfinite(point.exemplar.y)) {
                continue;
            }
            leaf.row[row] = std::uint8_t(leaf.row[row] | 1u << z);
            ++leaf.count;
            brick.samples.push_back(level_.codec.pack(point));
        }
        if (leaf.count) {
            brick.leaves.push_back(leaf);
        }
    }
}

void Scanner::fillBrick(Brick& brick, std::vector<Claim>& claims) {
    claims.assign(brickVoxels, Claim{0, 0, 0, -1, false});
    const Vec3i b = unpackBrick(brick.key) + lowest_;
    const Vec3i corner(b.x * brickSize, b.y * brickSize, b.z * brickSize);
    ShellPrism prism;
    for (std::size_t i = brick.begin; i < brick.end; ++i) {
        if (prism.set(surface_, boundary_, pairs_[i].triangle)) {
            claim(prism, std::int32_t(pairs_[i].triangle), corner, claims);
        }
    }
    folded_ += std::size_t(std::count_if(claims.begin(), claims.end(), [](const Claim& c) { return c.folded; }));
    makeSamples(brick, corner, claims);
}

ScanCounts Scanner::run() {
    progress_(0);
    findLowestBrick();
    listBricks();
    // So many at once that all threads are busy, and no more than fit into the cache beside what is kept.
    const std::size_t batch = 32 * std::size_t(std::max(1, threadCount()));
    for (std::size_t first = 0; first < bricks_.size(); first += batch) {
        const std::size_t count = std::min(batch, bricks_.size() - first);
        parallelFor(count, 4, [&](std::size_t begin, std::size_t end) {
            std::vector<Claim> claims;
            for (std::size_t i = begin; i < end; ++i) {
                fillBrick(bricks_[first + i], claims);
            }
        });
        for (std::size_t i = first; i < first + count; ++i) {
            const ShellSample* samples = bricks_[i].samples.data();
            for (const ShellLeaf& leaf : bricks_[i].leaves) {
                level_.add(leaf, samples);
                samples += leaf.count;
            }
            bricks_[i] = Brick{};
        }
        progress_(0.1 + 0.9 * double(first + count) / double(bricks_.size()));
    }
    level_.foldedVoxels = folded_;
    return {unusable_};
}

} // namespace

ShellPoint shellPoint(const ShellSource& source, std::size_t t, double b1, double b2, double depth) {
    const RefinedSurface& surface = source.surface;
    const Vec3i& tri = surface.triangles[t];
    const double b[3] = {1.0 - b1 - b2, b1, b2};
    ShellPoint out;
    Vec3d normal, gradient[2];
    for (int c = 0; c < 3; ++c) {
        const std::size_t i = 3 * t + std::size_t(c);
        out.exemplar.x += b[c] * double(source.map.cornerCoords[i].x);
        out.exemplar.y += b[c] * double(source.map.cornerCoords[i].y);
        normal += Vec3d(surface.normals[std::size_t(tri[c])]) * b[c];
        gradient[0] += Vec3d(source.map.gradientX[i]) * b[c];
        gradient[1] += Vec3d(source.map.gradientY[i]) * b[c];
    }
    normal = normalize(normal);
    ShellPrism prism;
    prism.set(surface, source.boundary, t);
    const ShellPrism::Point point{b1, b2, depth, false};
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
    out.depth = depth * source.mmPerUnit;
    out.gradX = gradient[0] / source.mmPerUnit;
    out.gradY = gradient[1] / source.mmPerUnit;
    // A faceted surface is shaded by its facets; its shared normals only say where the shell lies.
    Vec3d shading = normal;
    if (!surface.cornerNormals.empty()) {
        shading = Vec3d(0.0);
        for (std::size_t c = 0; c < 3; ++c) {
            shading += Vec3d(surface.cornerNormals[3 * t + c]) * b[c];
        }
    }
    out.normal = normalize(shading);
    out.triangle = std::uint32_t(t);
    out.b1 = float(b1);
    out.b2 = float(b2);
    return out;
}

ScanCounts scanShell(const ShellSource& source, ShellLevel& level, const std::function<void(double)>& progress) {
    return Scanner(source, level, progress).run();
}

} // namespace stf
