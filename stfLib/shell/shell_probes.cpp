// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_probes.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/shell/shell_prism.h"

#include <mutex>
#include <unordered_map>

namespace stf {

namespace {

constexpr std::uint64_t kSeed = 0x5348454c4c; ///< of the points; any would do

/// Points in cells of one size.
class PointCells {
public:
    PointCells(const std::vector<Vec3d>& points, double cell) : points_(points), perUnit_(1 / cell) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            cells_[keyOf(cellOf(points[i]))].push_back(std::uint32_t(i));
        }
    }
    /// Calls f(number) for all points in the box, and for some beside it.
    template<class F>
    void forEach(const Vec3d& lo, const Vec3d& hi, const F& f) const {
        const Vec3d a = cellOf(lo), b = cellOf(hi), n = b - a + Vec3d(1.0);
        if (!(n.x * n.y * n.z < double(cells_.size()))) {
            for (std::size_t i = 0; i < points_.size(); ++i) {
                f(i);
            }
            return;
        }
        for (double x = a.x; x <= b.x; ++x) {
            for (double y = a.y; y <= b.y; ++y) {
                for (double z = a.z; z <= b.z; ++z) {
                    if (const auto it = cells_.find(keyOf({x, y, z})); it != cells_.end()) {
                        for (std::uint32_t i : it->second) {
                            f(std::size_t(i));
                        }
                    }
                }
            }
        }
    }

private:
    Vec3d cellOf(const Vec3d& p) const {
        return {std::floor(p.x * perUnit_), std::floor(p.y * perUnit_), std::floor(p.z * perUnit_)};
    }
    /// Cells far apart may share a key, which costs time alone.
    static std::uint64_t keyOf(const Vec3d& c) {
        const auto bits = [](double v) { return std::uint64_t(std::int64_t(std::fmod(v, 1e6))) & 0x1fffffu; };
        return bits(c.x) << 42 | bits(c.y) << 21 | bits(c.z);
    }

    const std::vector<Vec3d>& points_;
    double perUnit_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

void grow(const Vec3d& p, Vec3d& lo, Vec3d& hi) {
    for (int a = 0; a < 3; ++a) {
        lo[a] = std::min(lo[a], p[a]);
        hi[a] = std::max(hi[a], p[a]);
    }
}

/// Points evenly over the volume; curvature left aside.
std::vector<Vec3d> scatter(const ShellSource& source, std::size_t count) {
    const std::size_t triangles = source.surface.triangles.size();
    std::vector<double> upTo(triangles);
    double total = 0;
    ShellPrism prism;
    for (std::size_t t = 0; t < triangles; ++t) {
        if (prism.set(source.surface, source.boundary, t)) {
            total += length(cross(prism.e1, prism.e2)) * prism.thickness(1.0 / 3, 1.0 / 3);
        }
        upTo[t] = total;
    }
    std::vector<Vec3d> points;
    if (!(total > 0) || !std::isfinite(total)) {
        return points;
    }
    for (std::size_t i = 0; i < count; ++i) {
        CounterRng random(kSeed, i);
        const double stratum = (double(i) + double(random.uniform())) / double(count);
        const std::size_t t = std::min(
            triangles - 1, std::size_t(std::upper_bound(upTo.begin(), upTo.end(), stratum * total) - upTo.begin()));
        double b1 = double(random.uniform()), b2 = double(random.uniform());
        if (b1 + b2 > 1) {
            b1 = 1 - b1;
            b2 = 1 - b2;
        }
        const double depth = double(random.uniform());
        if (prism.set(source.surface, source.boundary, t)) {
            // As floats, since lookups take those.
            points.emplace_back(Vec3f(prism.p0 + prism.e1 * b1 + prism.e2 * b2 -
                                      prism.direction(b1, b2) * (depth * prism.thickness(b1, b2))));
        }
    }
    return points;
}

struct Found {
    double b1 = 0, b2 = 0, depth = 0;
    std::int64_t triangle = -1;
    bool beats(const Found& o) const {
        const double a = std::abs(depth), b = std::abs(o.depth);
        return o.triangle < 0 || a < b || (a == b && triangle < o.triangle);
    }
};

/// The prism with the nearest surface at each point.
std::vector<Found> locate(const ShellSource& source, const std::vector<Vec3d>& points, double cell) {
    std::vector<Found> best(points.size());
    const PointCells cells(points, cell);
    std::mutex mutex;
    parallelFor(source.surface.triangles.size(), 8192, [&](std::size_t begin, std::size_t end) {
        std::vector<std::pair<std::size_t, Found>> found;
        ShellPrism prism;
        for (std::size_t t = begin; t < end; ++t) {
            if (!prism.set(source.surface, source.boundary, t)) {
                continue;
            }
            Vec3d lo(1e300), hi(-1e300);
            const double deep = prism.largestThickness();
            for (int c = 0; c < 3; ++c) {
                grow(prism.corner(c, 0), lo, hi);
                grow(prism.corner(c, deep), lo, hi);
            }
            const double slack = 1e-6 * (deep + length(hi - lo));
            cells.forEach(lo - Vec3d(slack), hi + Vec3d(slack), [&](std::size_t i) {
                const Vec3d& p = points[i];
                if (p.x < lo.x - slack || p.y < lo.y - slack || p.z < lo.z - slack || p.x > hi.x + slack ||
                    p.y > hi.y + slack || p.z > hi.z + slack) {
                    return;
                }
                ShellPrism::Point at;
                if (prism.invert(p - prism.p0, slack, slack, at)) {
                    found.push_back({i, {at.b1, at.b2, at.d, std::int64_t(t)}});
                }
            });
        }
        const std::lock_guard<std::mutex> lock(mutex);
        for (const auto& [i, f] : found) {
            if (f.beats(best[i])) {
                best[i] = f;
            }
        }
    });
    return best;
}

double distanceToSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d ab = b - a;
    const double l = dot(ab, ab);
    const double t = l > 0 ? std::clamp(dot(p - a, ab) / l, 0.0, 1.0) : 0.0;
    return length(p - a - ab * t);
}

} // namespace

std::vector<ProbedPoint> makeProbes(const ShellSource& source, const ShellEdges& edges, std::size_t count,
                                   double seamReach) {
    const std::vector<Vec3d> points = scatter(source, count);
    const std::vector<Found> found = locate(source, points, seamReach);
    std::vector<ProbedPoint> probes;
    std::vector<Vec3d> feet;
    ShellPrism prism;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Found& f = found[i];
        if (f.triangle < 0 || !prism.set(source.surface, source.boundary, std::size_t(f.triangle))) {
            continue; // rounding put it beside the shell
        }
        ProbedPoint p;
        p.point = points[i];
        p.exact = shellPoint(source, std::size_t(f.triangle), f.b1, f.b2, f.depth);
        p.seamDistance = seamReach;
        if (isFinite(p.exact.gradX) && isFinite(p.exact.gradY) && std::isfinite(p.exact.exemplar.x) &&
            std::isfinite(p.exact.exemplar.y)) {
            probes.push_back(p);
            feet.push_back(prism.p0 + prism.e1 * f.b1 + prism.e2 * f.b2);
        }
    }
    const PointCells cells(feet, seamReach);
    for (const auto& [p, q] : edges.seams) {
        const std::size_t ends[2] = {std::size_t(p), std::size_t(q)};
        Vec3d at[2], down[2];
        for (int e = 0; e < 2; ++e) {
            at[e] = Vec3d(source.surface.points[ends[e]]);
            down[e] = (Vec3d(source.boundary.inner[ends[e]]) - at[e]) / double(source.boundary.thickness[ends[e]]);
        }
        const Vec3d &a = at[0], &b = at[1];
        Vec3d lo = a, hi = a;
        grow(b, lo, hi);
        cells.forEach(lo - Vec3d(seamReach), hi + Vec3d(seamReach), [&](std::size_t i) {
            ProbedPoint& probe = probes[i];
            const double depth = probe.exact.depth / source.mmPerUnit;
            probe.seamDistance =
                std::min(probe.seamDistance, distanceToSegment(probe.point, a + down[0] * depth, b + down[1] * depth));
        });
    }
    return probes;
}

} // namespace stf
