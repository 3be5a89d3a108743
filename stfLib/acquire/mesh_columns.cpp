// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_columns.h"

#include "stfLib/base/error.h"
#include "stfLib/base/parallel.h"

#include <limits>
#include <sstream>
#include <tuple>

namespace stf {

namespace {

/// Samples along each edge of a voxel in which an open mesh has to be asked point by point: 64 in all.
constexpr int kSlices = 4;

int wrap(int i, int n) {
    return (i % n + n) % n;
}
int floorDivide(int i, int n) {
    return (i - wrap(i, n)) / n;
}

/// Whether the horizontal ray from (x, y) towards +x crosses the edge from a to b, and how: +1 upward, -1 downward.
int crossesRay(const Vec3d& a, const Vec3d& b, double x, double y) {
    if ((a.y > y) == (b.y > y)) {
        return 0;
    }
    // The same numbers in the same order for both triangles of the edge.
    const bool up = b.y > a.y;
    const Vec3d& lo = up ? a : b;
    const Vec3d& hi = up ? b : a;
    const double at = lo.x + (y - lo.y) / (hi.y - lo.y) * (hi.x - lo.x);
    return x < at ? (up ? 1 : -1) : 0;
}

double depthAt(const Vec3d& a, const Vec3d& b, const Vec3d& c, double x, double y) {
    const Vec3d normal = cross(b - a, c - a);
    const double lo = std::min({a.z, b.z, c.z}), hi = std::max({a.z, b.z, c.z});
    if (normal.z == 0) {
        return 0.5 * (lo + hi);
    }
    return std::clamp(a.z - (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z, lo, hi);
}

struct Span {
    int lo, hi;
};

/// The same surface in triangles of edges no longer than `longest`: a tree of compact triangles has compact nodes,
/// which far away count as one. Stops at `most` triangles.
TriangleMesh split(const TriangleMesh& mesh, double longest, std::size_t most) {
    TriangleMesh result = mesh;
    for (std::size_t i = 0; i < result.triangles.size() && result.triangles.size() < most;) {
        int edge = 0;
        double squares = 0;
        for (int k = 0; k < 3; ++k) {
            const Vec3d d = result.corner(i, (k + 1) % 3) - result.corner(i, k);
            if (dot(d, d) > squares) {
                squares = dot(d, d);
                edge = k;
            }
        }
        if (squares <= longest * longest) {
            ++i;
            continue;
        }
        const Vec3i t = result.triangles[i];
        const int a = t[edge], b = t[(edge + 1) % 3], c = t[(edge + 2) % 3], middle = int(result.points.size());
        result.points.push_back((result.points[std::size_t(a)] + result.points[std::size_t(b)]) * 0.5);
        result.triangles[i] = {a, middle, c};
        result.triangles.push_back({middle, b, c});
    }
    return result;
}

} // namespace

MeshColumns::MeshColumns(MendedMesh mesh, const TileGrid& grid, double maxBytes)
    : mended_(std::move(mesh)), closed_(mended_.mesh), grid_(grid) {
    append(closed_, mended_.caps);
    box_ = boundsOf(closed_);
    const Vec3d h = grid_.voxelMm;
    const double reach = 30000.0 * std::min(grid_.size.x, grid_.size.y);
    if (std::max({std::abs(box_.lo.x), std::abs(box_.hi.x), std::abs(box_.lo.y), std::abs(box_.hi.y)}) >
        reach * std::min(h.x, h.y)) {
        throw Error("reaches more than 30000 tiles away from the tile");
    }
    const auto columns = [&](std::size_t t, Span& x, Span& y) {
        const Vec3d &a = closed_.corner(t, 0), &b = closed_.corner(t, 1), &c = closed_.corner(t, 2);
        x = {int(std::floor(std::min({a.x, b.x, c.x}) / h.x)), int(std::floor(std::max({a.x, b.x, c.x}) / h.x))};
        y = {int(std::floor(std::min({a.y, b.y, c.y}) / h.y)), int(std::floor(std::max({a.y, b.y, c.y}) / h.y))};
    };
    const auto column = [&](int x, int y) {
        return std::size_t(wrap(x, grid_.size.x)) + std::size_t(grid_.size.x) * std::size_t(wrap(y, grid_.size.y));
    };
    double total = 0;
    Span xs{}, ys{};
    for (std::size_t t = 0; t < closed_.triangles.size(); ++t) {
        columns(t, xs, ys);
        total += (double(xs.hi) - xs.lo + 1) * (double(ys.hi) - ys.lo + 1);
    }
    if (total * sizeof(Item) > maxBytes) {
        std::ostringstream s;
        s << "covers so many columns of the tile (" << total << " of its triangles in columns) that it would take "
          << std::ceil(total * sizeof(Item) / 1e6) << " MB; it is " << box_.size().x << " x " << box_.size().y
          << " mm wide, the tile " << grid_.extentMm().x << " x " << grid_.extentMm().y;
        throw Error(s.str());
    }
    start_.assign(std::size_t(grid_.size.x) * std::size_t(grid_.size.y) + 1, 0);
    for (int pass = 0; pass < 2; ++pass) {
        // First the counts, then the items from the back of each column on.
        for (std::size_t t = closed_.triangles.size(); t-- > 0;) {
            columns(t, xs, ys);
            for (int y = ys.lo; y <= ys.hi; ++y) {
                for (int x = xs.lo; x <= xs.hi; ++x) {
                    if (pass == 0) {
                        ++start_[column(x, y)];
                    } else {
                        items_[--start_[column(x, y)]] = {std::uint32_t(t), std::int16_t(floorDivide(x, grid_.size.x)),
                                                          std::int16_t(floorDivide(y, grid_.size.y))};
                    }
                }
            }
        }
        if (pass == 0) {
            for (std::size_t i = 1; i < start_.size(); ++i) {
                start_[i] += start_[i - 1];
            }
            items_.resize(start_.back());
        }
    }
    if (!mended_.caps.triangles.empty()) {
        caps_ = std::make_unique<TriangleTree>(mended_.caps);
        preparePatches();
    }
}

void MeshColumns::capWinding(int u, int v, const std::vector<int>& depths, double* out) const {
    std::vector<Crossing> all;
    crossings(wrap(u, grid_.size.x), wrap(v, grid_.size.y), {{0, 0}}, all);
    for (const int z : depths) {
        const Vec3d at = Vec3d(double(u), double(v), double(z)) * grid_.voxelMm;
        int winding = 0;
        for (const Crossing& c : all) {
            const bool here = c.imageX == floorDivide(u, grid_.size.x) && c.imageY == floorDivide(v, grid_.size.y);
            winding += here && c.depth < at.z ? c.turn : 0;
        }
        *out++ = winding - tree_->windingNumber(at);
    }
}

std::vector<char> MeshColumns::cornersToAsk(std::vector<int>& corner, const Vec3i& n) const {
    // Away from the caps their winding number is harmonic: blocks at whose corners it rounds to one number, well within
    // it, need not be asked in between.
    constexpr int kBlock = 4;
    constexpr double kMargin = 0.2;
    const Vec3i blocks((n.x + kBlock - 2) / kBlock, (n.y + kBlock - 2) / kBlock, (n.z + kBlock - 2) / kBlock);
    const auto node = [&](int block, int limit) { return std::min(block * kBlock, limit - 1); };
    std::vector<int> depths;
    for (int z = 0; z <= blocks.z; ++z) {
        depths.push_back(patchFrom_.z + node(z, n.z));
    }
    std::vector<double> coarse(std::size_t(blocks.x + 1) * std::size_t(blocks.y + 1) * depths.size());
    const std::size_t row = std::size_t(blocks.x + 1);
    parallelFor(row * std::size_t(blocks.y + 1), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            capWinding(patchFrom_.x + node(int(i % row), n.x), patchFrom_.y + node(int(i / row), n.y), depths,
                       coarse.data() + i * depths.size());
        }
    });
    std::vector<char> ask(corner.size(), 0);
    const std::size_t nx = std::size_t(n.x), ny = std::size_t(n.y);
    const double reach = 0.5 * (kBlock + 1) * length(grid_.voxelMm);
    for (int z = 0; z < blocks.z; ++z) {
        for (int y = 0; y < blocks.y; ++y) {
            for (int x = 0; x < blocks.x; ++x) {
                double lo = 1e300, hi = -1e300;
                for (int k = 0; k < 8; ++k) {
                    const std::size_t at = std::size_t(x + (k & 1)) + row * std::size_t(y + (k >> 1 & 1));
                    const double c = coarse[at * depths.size() + std::size_t(z + (k >> 2))];
                    lo = std::min(lo, c);
                    hi = std::max(hi, c);
                }
                const Vec3d middle =
                    (Vec3d(patchFrom_ + Vec3i(x, y, z) * kBlock) + Vec3d(0.5 * kBlock)) * grid_.voxelMm;
                const double level = std::floor(0.5 + lo);
                const bool settled =
                    lo - level > kMargin - 0.5 && hi - level < 0.5 - kMargin && caps_->distance(middle, reach) >= reach;
                for (int k = node(z, n.z); k <= node(z + 1, n.z); ++k) {
                    for (int j = node(y, n.y); j <= node(y + 1, n.y); ++j) {
                        for (int i = node(x, n.x); i <= node(x + 1, n.x); ++i) {
                            const std::size_t c = std::size_t(i) + nx * (std::size_t(j) + ny * std::size_t(k));
                            if (settled) {
                                corner[c] = int(level) + 1;
                            } else {
                                ask[c] = 1;
                            }
                        }
                    }
                }
            }
        }
    }
    return ask;
}

void MeshColumns::preparePatches() {
    const Vec3d h = grid_.voxelMm;
    Vec3i to;
    for (int k = 0; k < 3; ++k) {
        patchFrom_[k] = int(std::floor(box_.lo[k] / h[k]));
        to[k] = int(std::floor(box_.hi[k] / h[k])) + 1;
    }
    patchFrom_.z = std::clamp(patchFrom_.z, 0, grid_.size.z);
    to.z = std::clamp(to.z, patchFrom_.z, grid_.size.z);
    patchSize_ = to - patchFrom_;
    if (patchSize_.z == 0) {
        return; // wholly above or below the tile
    }
    const Vec3d n = Vec3d(patchSize_) + Vec3d(1.0);
    if (n.x * n.y * n.z > 2.7e8) {
        throw Error("has holes and is too large to find out what is inside (" + std::to_string(patchSize_.x) + " x " +
                    std::to_string(patchSize_.y) + " x " + std::to_string(patchSize_.z) + " voxels around it)");
    }
    const std::size_t nx = std::size_t(n.x), ny = std::size_t(n.y);
    // Winding number of the caps at the corners of voxels, as that of both less that of the mesh (the long triangles of
    // fans would be slow): where it rounds to the same number all around a voxel that no cap passes through, that is
    // the number for all of it.
    tree_ = std::make_unique<TriangleTree>(
        split(mended_.mesh, length(box_.size()) / 24, 4 * mended_.mesh.triangles.size() + 1'000'000));
    std::vector<int> corner(nx * ny * std::size_t(n.z));
    const std::vector<char> ask = cornersToAsk(corner, patchSize_ + Vec3i(1));
    parallelFor(nx * ny, 16, [&](std::size_t begin, std::size_t end) {
        std::vector<int> depths;
        std::vector<double> caps;
        for (std::size_t i = begin; i < end; ++i) {
            depths.clear();
            for (std::size_t z = 0; z < std::size_t(n.z); ++z) {
                if (ask[i + nx * ny * z]) {
                    depths.push_back(patchFrom_.z + int(z));
                }
            }
            caps.resize(depths.size());
            capWinding(patchFrom_.x + int(i % nx), patchFrom_.y + int(i / nx), depths, caps.data());
            for (std::size_t k = 0; k < depths.size(); ++k) {
                corner[i + nx * ny * std::size_t(depths[k] - patchFrom_.z)] = int(std::floor(0.5 + caps[k])) + 1;
            }
        }
    });
    threshold_.assign(std::size_t(patchSize_.x) * std::size_t(patchSize_.y) * std::size_t(patchSize_.z), kMixed);
    const double reach = 0.5 * length(h);
    parallelFor(threshold_.size(), std::size_t(patchSize_.x), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t x = i % std::size_t(patchSize_.x),
                              y = i / std::size_t(patchSize_.x) % std::size_t(patchSize_.y),
                              z = i / std::size_t(patchSize_.x) / std::size_t(patchSize_.y);
            const int value = corner[x + nx * (y + ny * z)];
            bool same = true;
            for (std::size_t k = 1; k < 8; ++k) {
                same = same && corner[x + (k & 1) + nx * (y + (k >> 1 & 1) + ny * (z + (k >> 2)))] == value;
            }
            const Vec3d middle = (Vec3d(patchFrom_) + Vec3d(double(x) + 0.5, double(y) + 0.5, double(z) + 0.5)) * h;
            if (same && caps_->distance(middle, reach) >= reach) {
                threshold_[i] = value;
            }
        }
    });
    // The caps are where they are by choice: what they add to one number and take from the other is smooth but for the
    // mesh itself, and is interpolated where that is not near.
    const auto middleOf = [&](std::size_t i) {
        return Vec3d(patchFrom_) + Vec3d(double(i % std::size_t(patchSize_.x)) + 0.5,
                                         double(i / std::size_t(patchSize_.x) % std::size_t(patchSize_.y)) + 0.5,
                                         double(i / std::size_t(patchSize_.x) / std::size_t(patchSize_.y)) + 0.5);
    };
    std::vector<std::size_t> mixed;
    for (std::size_t i = 0; i < threshold_.size(); ++i) {
        if (threshold_[i] == kMixed) {
            mixed.push_back(i);
        }
    }
    samples_.assign(mixed.size(), 0);
    parallelFor(mixed.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t m = begin; m < end; ++m) {
            const Vec3d corner0 = middleOf(mixed[m]) - Vec3d(0.5);
            const bool smooth = tree_->distance((corner0 + Vec3d(0.5)) * h, reach) >= reach;
            double c[8] = {};
            for (int k = 0; smooth && k < 8; ++k) {
                c[k] = tree_->windingNumber((corner0 + Vec3d(k & 1, k >> 1 & 1, k >> 2)) * h);
            }
            for (int s = 0; s < kSlices * kSlices * kSlices; ++s) {
                const Vec3d f =
                    (Vec3d(s % kSlices, s / kSlices % kSlices, s / (kSlices * kSlices)) + Vec3d(0.5)) / double(kSlices);
                const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
                const double winding = smooth ? mix(mix(mix(c[0], c[1], f.x), mix(c[2], c[3], f.x), f.y),
                                                    mix(mix(c[4], c[5], f.x), mix(c[6], c[7], f.x), f.y), f.z)
                                              : tree_->windingNumber((corner0 + f) * h);
                samples_[m] |= std::uint64_t(winding > 0.5) << s;
            }
            threshold_[mixed[m]] = kMixed + int(m);
        }
    });
}

int MeshColumns::threshold(int x, int y, int z) const {
    const Vec3i p = Vec3i(x, y, z) - patchFrom_;
    return threshold_[std::size_t(p.x) +
                      std::size_t(patchSize_.x) * (std::size_t(p.y) + std::size_t(patchSize_.y) * std::size_t(p.z))];
}

void MeshColumns::crossings(int x, int y, const std::vector<Vec2d>& lines, std::vector<Crossing>& out) const {
    const Vec3d extent = grid_.extentMm(), h = grid_.voxelMm;
    const std::size_t column = std::size_t(x) + std::size_t(grid_.size.x) * std::size_t(y);
    for (std::size_t i = start_[column]; i < start_[column + 1]; ++i) {
        const Item& item = items_[i];
        const std::size_t t = item.triangle;
        const Vec3d &a = closed_.corner(t, 0), &b = closed_.corner(t, 1), &c = closed_.corner(t, 2);
        const double lo = std::min({a.y, b.y, c.y}), hi = std::max({a.y, b.y, c.y});
        for (std::size_t l = 0; l < lines.size(); ++l) {
            const double px = (x + lines[l].x) * h.x + item.imageX * extent.x;
            const double py = (y + lines[l].y) * h.y + item.imageY * extent.y;
            if (py < lo || py > hi) {
                continue;
            }
            const int turn = crossesRay(a, b, px, py) + crossesRay(b, c, px, py) + crossesRay(c, a, px, py);
            if (turn != 0) {
                // Counter-clockwise from +z: the outside is deeper, the line leaves the mesh.
                out.push_back({int(l), -turn, item.imageX, item.imageY, depthAt(a, b, c, px, py)});
            }
        }
    }
}

void MeshColumns::inside(int x, int y, const std::vector<Vec2d>& lines, std::vector<Stretch>& out) const {
    std::vector<Crossing> all;
    crossings(x, y, lines, all);
    // The order of crossings at one depth does not change what is inside for any length.
    std::sort(all.begin(), all.end(), [](const Crossing& s, const Crossing& t) {
        return std::tie(s.line, s.imageX, s.imageY, s.depth, s.turn) <
               std::tie(t.line, t.imageX, t.imageY, t.depth, t.turn);
    });
    const double bottom = grid_.extentMm().z;
    if (!caps_) {
        for (std::size_t i = 0; i < all.size();) {
            int winding = 0;
            std::size_t k = i;
            for (; k < all.size() && all[k].line == all[i].line && all[k].imageX == all[i].imageX &&
                   all[k].imageY == all[i].imageY;
                 ++k) {
                if (winding >= 1) {
                    const double from = std::max(0.0, all[k - 1].depth), to = std::min(bottom, all[k].depth);
                    if (from < to) {
                        out.push_back({all[k].line, from, to});
                    }
                }
                winding += all[k].turn;
            }
            i = k;
        }
        return;
    }
    // An open mesh may hold what no triangle is above of: all lines within its box are looked at, in every repetition.
    for (int v = patchFrom_.y; v < patchFrom_.y + patchSize_.y; ++v) {
        for (int u = patchFrom_.x; u < patchFrom_.x + patchSize_.x; ++u) {
            // Only the columns that fall on this one: u and v step by the tile once they do.
            if (wrap(u, grid_.size.x) != x) {
                continue;
            }
            if (wrap(v, grid_.size.y) != y) {
                break;
            }
            for (std::size_t l = 0; l < lines.size(); ++l) {
                const auto key = std::make_tuple(int(l), floorDivide(u, grid_.size.x), floorDivide(v, grid_.size.y));
                const auto before = [](const Crossing& s, const std::tuple<int, int, int>& k) {
                    return std::make_tuple(s.line, s.imageX, s.imageY) < k;
                };
                const auto after = [](const std::tuple<int, int, int>& k, const Crossing& s) {
                    return k < std::make_tuple(s.line, s.imageX, s.imageY);
                };
                const auto begin = std::lower_bound(all.begin(), all.end(), key, before);
                const auto end = std::upper_bound(begin, all.end(), key, after);
                insideOpen(u, v, lines[l], int(l), all.data() + (begin - all.begin()), all.data() + (end - all.begin()),
                           out);
            }
        }
    }
}

void MeshColumns::insideOpen(int u, int v, const Vec2d& at, int line, const Crossing* begin, const Crossing* end,
                             std::vector<Stretch>& out) const {
    const Vec3d h = grid_.voxelMm;
    const auto add = [&](double from, double to) {
        if (from < to) {
            if (!out.empty() && out.back().line == line && out.back().to == from) {
                out.back().to = to;
            } else {
                out.push_back({line, from, to});
            }
        }
    };
    const Crossing* next = begin;
    int winding = 0;
    for (int z = patchFrom_.z; z < patchFrom_.z + patchSize_.z; ++z) {
        const double top = z * h.z, bottom = (z + 1) * h.z;
        while (next != end && next->depth <= top) {
            winding += next++->turn;
        }
        const int limit = threshold(u, v, z);
        if (limit < kMixed) {
            double from = top;
            int w = winding;
            for (const Crossing* c = next;; ++c) {
                const bool last = c == end || c->depth >= bottom;
                const double to = last ? bottom : c->depth;
                if (w >= limit) {
                    add(from, to);
                }
                if (last) {
                    break;
                }
                w += c->turn;
                from = to;
            }
            continue;
        }
        const std::uint64_t samples = samples_[std::size_t(limit - kMixed)];
        const int place =
            std::min(int(at.x * kSlices), kSlices - 1) + kSlices * std::min(int(at.y * kSlices), kSlices - 1);
        for (int k = 0; k < kSlices; ++k) {
            if (samples >> (place + kSlices * kSlices * k) & 1) {
                add(top + double(k) / kSlices * h.z, top + double(k + 1) / kSlices * h.z);
            }
        }
    }
}

std::vector<double> MeshColumns::first(int x, int y, const std::vector<Vec2d>& lines) const {
    std::vector<double> depth(lines.size(), std::numeric_limits<double>::infinity());
    std::vector<Crossing> all;
    crossings(x, y, lines, all);
    for (const Crossing& c : all) {
        depth[std::size_t(c.line)] = std::min(depth[std::size_t(c.line)], c.depth);
    }
    return depth;
}

} // namespace stf
