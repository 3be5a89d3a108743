// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_distance.h"

#include "stfLib/base/parallel.h"

#include <atomic>

namespace stf {

namespace {

const std::vector<Vec2d> kMiddle{{0.5, 0.5}};

/// Triangles that bound material against the outside: without walls between neighbouring tiles and without the bottom.
TriangleMesh boundary(const TriangleMesh& mesh, const TileGrid& grid) {
    const Vec3d extent = grid.extentMm();
    const Box3d box = boundsOf(mesh);
    TriangleMesh result;
    result.points = mesh.points;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        bool wall = false;
        for (int axis = 0; axis < 2; ++axis) {
            const double slack = 1e-6 * extent[axis];
            const auto lies = [&](double at) {
                for (int k = 0; k < 3; ++k) {
                    if (std::abs(mesh.corner(i, k)[axis] - at) > slack) {
                        return false;
                    }
                }
                return true;
            };
            const bool spans = std::abs(box.size()[axis] - extent[axis]) < slack;
            wall = wall || (spans && (lies(box.lo[axis]) || lies(box.hi[axis])));
        }
        const double slack = 1e-6 * extent.z;
        const bool bottom =
            std::min({mesh.corner(i, 0).z, mesh.corner(i, 1).z, mesh.corner(i, 2).z}) >= extent.z - slack;
        if (!wall && !bottom) {
            result.triangles.push_back(mesh.triangles[i]);
        }
    }
    return result;
}

/// The triangles of a relief that its upper envelope shows, at least at a corner or in the middle, and a floor where it
/// has none. What hides below would make distances short.
TriangleMesh envelope(const CoverBody& body, const TileGrid& grid) {
    const MeshColumns& relief = *body.meshes.front();
    const TriangleMesh all = boundary(relief.mended().mesh, grid);
    const Vec3d h = grid.voxelMm, extent = grid.extentMm();
    const auto shown = [&](Vec3d p) {
        p.x -= extent.x * std::floor(p.x / extent.x);
        p.y -= extent.y * std::floor(p.y / extent.y);
        const int x = std::min(int(p.x / h.x), grid.size.x - 1), y = std::min(int(p.y / h.y), grid.size.y - 1);
        return relief.first(x, y, {{p.x / h.x - x, p.y / h.y - y}})[0] >= p.z - 0.01 * h.z;
    };
    std::vector<char> kept(all.triangles.size(), 0);
    parallelFor(kept.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d &a = all.corner(i, 0), &b = all.corner(i, 1), &c = all.corner(i, 2);
            const Vec3d middle = (a + b + c) / 3.0, normal = normalize(cross(b - a, c - a));
            // A wall is seen from one of its sides.
            const Vec3d aside = Vec3d(normal.x, normal.y, 0) * (0.01 * std::min(h.x, h.y));
            for (const Vec3d& p : {middle, a * 0.9 + middle * 0.1, b * 0.9 + middle * 0.1, c * 0.9 + middle * 0.1}) {
                kept[i] = kept[i] || shown(p) || shown(p + aside) || shown(p - aside);
            }
        }
    });
    TriangleMesh result;
    result.points = all.points;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        if (kept[i]) {
            result.triangles.push_back(all.triangles[i]);
        }
    }
    for (int y = 0; y < grid.size.y; ++y) {
        for (int x = 0; x < grid.size.x; ++x) {
            if (std::isinf(relief.first(x, y, kMiddle)[0])) {
                const int first = int(result.points.size());
                for (int k = 0; k < 4; ++k) {
                    result.points.push_back({(x + (k & 1)) * h.x, (y + (k >> 1)) * h.y, body.reliefFloor});
                }
                result.triangles.push_back({first, first + 1, first + 2});
                result.triangles.push_back({first + 1, first + 3, first + 2});
            }
        }
    }
    return result;
}

/// A tree of triangles that repeats with the tile.
class PeriodicTree {
public:
    PeriodicTree(const TriangleMesh& mesh, const TileGrid& grid)
        : tree_(mesh), box_(boundsOf(mesh)), extent_(grid.extentMm()) {}
    double distance(const Vec3d& p, double bound, std::size_t& hint) const {
        if (tree_.empty()) {
            return bound;
        }
        double best = bound;
        const Vec3d middle = box_.middle();
        const int nearX = int(std::round((middle.x - p.x) / extent_.x)),
                  nearY = int(std::round((middle.y - p.y) / extent_.y));
        best = tree_.distance(shifted(p, nearX, nearY), best, hint);
        const int x0 = int(std::ceil((box_.lo.x - best - p.x) / extent_.x)),
                  x1 = int(std::floor((box_.hi.x + best - p.x) / extent_.x));
        const int y0 = int(std::ceil((box_.lo.y - best - p.y) / extent_.y)),
                  y1 = int(std::floor((box_.hi.y + best - p.y) / extent_.y));
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) {
                const Vec3d q = shifted(p, x, y);
                if ((x != nearX || y != nearY) && box_.distance(q) < best) {
                    best = tree_.distance(q, best, hint);
                }
            }
        }
        return best;
    }
    /// Where winding number and 1/2 are nearest to each other, over all repetitions: in mm to first order, at least 0.
    double toLevel(const Vec3d& p, double step) const {
        double best = 1e300;
        const int x0 = int(std::ceil((box_.lo.x - p.x) / extent_.x)),
                  x1 = int(std::floor((box_.hi.x - p.x) / extent_.x));
        const int y0 = int(std::ceil((box_.lo.y - p.y) / extent_.y)),
                  y1 = int(std::floor((box_.hi.y - p.y) / extent_.y));
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) {
                const Vec3d q = shifted(p, x, y);
                Vec3d gradient;
                for (int k = 0; k < 3; ++k) {
                    Vec3d lo = q, hi = q;
                    lo[k] -= step;
                    hi[k] += step;
                    gradient[k] = (tree_.windingNumber(hi) - tree_.windingNumber(lo)) / (2 * step);
                }
                const double slope = length(gradient);
                if (slope > 0) {
                    best = std::min(best, std::abs(tree_.windingNumber(q) - 0.5) / slope);
                }
            }
        }
        return best;
    }

private:
    Vec3d shifted(const Vec3d& p, int x, int y) const { return p + Vec3d(x * extent_.x, y * extent_.y, 0); }
    TriangleTree tree_;
    Box3d box_;
    Vec3d extent_;
};

/// Where a hole lets the outside in, no triangle is near: there the distance is that to the level 1/2. Only beside a
/// change of sign is the first order good for anything, and needed.
void mendHoles(const PeriodicTree& tree, const TileGrid& grid, std::vector<float>& distance) {
    const std::vector<float> before = distance;
    const Vec3i n = grid.size;
    const auto at = [&](int x, int y, int z) {
        return before[std::size_t((x + n.x) % n.x) +
                      std::size_t(n.x) *
                          (std::size_t((y + n.y) % n.y) + std::size_t(n.y) * std::size_t(std::clamp(z, 0, n.z - 1)))];
    };
    const double edge = minComponent(grid.voxelMm);
    parallelFor(distance.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const int x = int(i % std::size_t(n.x)), y = int(i / std::size_t(n.x) % std::size_t(n.y)),
                      z = int(i / std::size_t(n.x) / std::size_t(n.y));
            const bool in = before[i] < 0;
            bool beside = false;
            for (int k = 0; k < 27 && !beside; ++k) {
                beside = (at(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1) < 0) != in;
            }
            if (beside && std::abs(double(before[i])) > 0.25 * edge) {
                const double level = tree.toLevel(Vec3d(x + 0.5, y + 0.5, z + 0.5) * grid.voxelMm, 0.25 * edge);
                distance[i] = float(std::copysign(std::min(level, std::abs(double(before[i]))), double(before[i])));
            }
        }
    });
}

/// Distances to a tree; inside(x, y, stretches) tells where the middle line of a column is inside.
template<class Inside>
std::vector<float> distances(const PeriodicTree& tree, bool open, const TileGrid& grid, Progress& progress,
                             Inside inside) {
    const Vec3d h = grid.voxelMm;
    const std::size_t columns = std::size_t(grid.size.x) * std::size_t(grid.size.y);
    // Where nothing is near in any repetition: further than the tile is large.
    const double far = 2 * length(grid.extentMm());
    std::vector<float> result(columns * std::size_t(grid.size.z));
    std::atomic<std::size_t> done{0};
    parallelFor(columns, 64, [&](std::size_t begin, std::size_t end) {
        std::vector<Stretch> stretches;
        for (std::size_t c = begin; c < end; ++c) {
            const int x = int(c % std::size_t(grid.size.x)), y = int(c / std::size_t(grid.size.x));
            stretches.clear();
            inside(x, y, stretches);
            double before = far;
            std::size_t hint = 0;
            for (int z = 0; z < grid.size.z; ++z) {
                const Vec3d p = Vec3d(x + 0.5, y + 0.5, z + 0.5) * h;
                // The voxel above bounds it, which makes the search short.
                double d = tree.distance(p, std::min(far, before + 1.001 * h.z), hint);
                before = d;
                const bool in = std::any_of(stretches.begin(), stretches.end(),
                                            [&](const Stretch& s) { return s.from <= p.z && p.z < s.to; });
                result[c + columns * std::size_t(z)] = float(in ? -d : d);
            }
        }
        progress.update("distance", double(done += end - begin) / double(columns));
    });
    if (open) {
        mendHoles(tree, grid, result);
    }
    return result;
}

} // namespace

std::vector<float> signedDistance(const MeshColumns& mesh, const TileGrid& grid, Progress& progress) {
    const PeriodicTree tree(boundary(mesh.mended().mesh, grid), grid);
    return distances(tree, !mesh.mended().caps.triangles.empty(), grid, progress,
                     [&](int x, int y, std::vector<Stretch>& out) { mesh.inside(x, y, kMiddle, out); });
}

std::vector<float> signedDistance(const CoverBody& body, const TileGrid& grid, Progress& progress) {
    const std::size_t layer = std::size_t(grid.size.x) * std::size_t(grid.size.y);
    std::vector<float> result(layer * std::size_t(grid.size.z), float(2 * length(grid.extentMm())));
    if (body.material < 0) {
        return result;
    }
    if (body.kind == CoverBody::Kind::Full) {
        for (std::size_t i = 0; i < result.size(); ++i) {
            result[i] = float(-(double(i / layer) + 0.5) * grid.voxelMm.z);
        }
    } else if (body.kind == CoverBody::Kind::Relief) {
        const PeriodicTree tree(envelope(body, grid), grid);
        return distances(tree, false, grid, progress, [&](int x, int y, std::vector<Stretch>& out) {
            bodyStretches(body, grid, x, y, kMiddle, out);
        });
    } else {
        for (const MeshColumns* mesh : body.meshes) {
            const std::vector<float> d = signedDistance(*mesh, grid, progress);
            std::transform(d.begin(), d.end(), result.begin(), result.begin(),
                           [](float a, float b) { return std::min(a, b); });
        }
    }
    return result;
}

std::vector<float> signedDistance(const CoverBody& body, const std::vector<CoverObject>& objects,
                                  const std::vector<char>& protrudes, const TileGrid& grid, Progress& progress) {
    std::vector<float> result = signedDistance(body, grid, progress);
    for (std::size_t o = 0; o < objects.size(); ++o) {
        const bool hollow = objects[o].material < 0;
        if (hollow || protrudes[o]) {
            const std::vector<float> d = signedDistance(*objects[o].columns, grid, progress);
            for (std::size_t i = 0; i < d.size(); ++i) {
                result[i] = hollow ? std::max(result[i], -d[i]) : std::min(result[i], d[i]);
            }
        }
    }
    return result;
}

} // namespace stf
