// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/surface_charts.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/surface/connection_energy.h"
#include "stfLib/surface/direction_field.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <queue>

namespace stf {

namespace {

constexpr float kPi = 3.14159265f;
constexpr int kRelaxSweeps = 24;
constexpr float kLargestStretch = 1.6f; ///< and its inverse: beyond, a vertex is left to another chart
constexpr float kStrainedShare = 0.15f; ///< of a chart: more, and it is grown again without following the field
constexpr float kDisagreement = 0.6f;   ///< of an edge: fronts that meet further apart do not join
constexpr int kRounds = 6;

Vec2f rotated(const Vec2f& v, float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    return {c * v.x - s * v.y, s * v.x + c * v.y};
}

float norm(const Vec2f& v) {
    return std::sqrt(v.x * v.x + v.y * v.y);
}

/// One chart while it grows.
struct Growth {
    std::vector<int> vertices; ///< in the order in which the front reached them
    std::vector<Vec2f> coords;
    std::vector<float> angle, distance, strain;
    bool metSingularity = false;
    float strainedShare = 0;
};

/// Grows charts one after the other; keeps its scratch memory.
class Grower {
public:
    Grower(const SurfaceGraph& g, const SurfaceSteps& steps, const std::vector<char>& singular)
        : g_(g), steps_(steps), singular_(singular), slot_(g.size(), kNone) {}

    Growth grow(int seed, float radius, bool rigid) {
        Growth out;
        spread(seed, radius, rigid, out);
        relax(out);
        measure(out);
        for (int v : touched_) {
            slot_[std::size_t(v)] = kNone;
        }
        touched_.clear();
        return out;
    }

private:
    static constexpr int kNone = -1, kRejected = -2;
    using Item = std::pair<float, int>;

    void spread(int seed, float radius, bool rigid, Growth& out) {
        std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
        queue.push({0.0f, seed});
        while (!queue.empty()) {
            const auto [distance, v] = queue.top();
            queue.pop();
            if (slot_[std::size_t(v)] != kNone) {
                continue;
            }
            touched_.push_back(v);
            Vec2f coord{0, 0};
            float angle = 0;
            if (!predict(v, rigid, out, coord, angle)) {
                slot_[std::size_t(v)] = kRejected;
                continue;
            }
            out.metSingularity = out.metSingularity || singular_[std::size_t(v)];
            slot_[std::size_t(v)] = int(out.vertices.size());
            out.vertices.push_back(v);
            out.coords.push_back(coord);
            out.angle.push_back(angle);
            out.distance.push_back(distance);
            for (int k = g_.first[std::size_t(v)]; k < g_.first[std::size_t(v) + 1]; ++k) {
                const int u = g_.neighbour[std::size_t(k)];
                const float d = distance + norm(steps_.stepMm[std::size_t(k)]);
                if (slot_[std::size_t(u)] == kNone && d <= radius) {
                    queue.push({d, u});
                }
            }
        }
    }

    /// Mean of what the neighbours reached so far foresee; false where they disagree.
    bool predict(int v, bool rigid, const Growth& out, Vec2f& coord, float& angle) const {
        Vec2f turned{0, 0};
        int count = 0;
        for (int k = g_.first[std::size_t(v)]; k < g_.first[std::size_t(v) + 1]; ++k) {
            const int s = slot_[std::size_t(g_.neighbour[std::size_t(k)])];
            if (s >= 0) {
                // The angle from the chart's frame to the field grows as the field turns; turn[k] belongs to the way
                // from v to its neighbour, this is the way back.
                const float a = rigid ? out.angle[std::size_t(s)] - steps_.turn[std::size_t(k)] : 0.0f;
                turned = turned + Vec2f(std::cos(a), std::sin(a));
                ++count;
            }
        }
        if (count == 0) {
            return true; // the seed
        }
        angle = rigid ? std::atan2(turned.y, turned.x) : 0.0f;
        Vec2f sum{0, 0};
        for (int k = g_.first[std::size_t(v)]; k < g_.first[std::size_t(v) + 1]; ++k) {
            const int s = slot_[std::size_t(g_.neighbour[std::size_t(k)])];
            if (s >= 0) {
                sum = sum + foreseen(out, s, k, angle);
            }
        }
        coord = sum * (1.0f / float(count));
        for (int k = g_.first[std::size_t(v)]; k < g_.first[std::size_t(v) + 1]; ++k) {
            const int s = slot_[std::size_t(g_.neighbour[std::size_t(k)])];
            if (s >= 0 &&
                norm(foreseen(out, s, k, angle) - coord) > kDisagreement * norm(steps_.wantedMm[std::size_t(k)])) {
                return false;
            }
        }
        return true;
    }

    /// Where the neighbour in slot s, reached over link k of a vertex of the given angle, puts that vertex.
    Vec2f foreseen(const Growth& out, int s, int k, float angle) const {
        const Vec2f& step = steps_.wantedMm[std::size_t(k)];
        const float other = out.angle[std::size_t(s)];
        if (angle == 0 && other == 0) {
            return out.coords[std::size_t(s)] - step;
        }
        // The mean of both angles, along the shorter way.
        float d = other - angle;
        d -= 2 * kPi * std::nearbyint(d / (2 * kPi));
        return out.coords[std::size_t(s)] - rotated(step, angle + 0.5f * d);
    }

    /// Gauss-Seidel on the least-squares coordinates, inward and outward by turns.
    void relax(Growth& out) {
        const std::size_t n = out.vertices.size();
        for (int sweep = 0; sweep < kRelaxSweeps; ++sweep) {
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t s = sweep & 1 ? n - 1 - i : i;
                const int v = out.vertices[s];
                Vec2f sum{0, 0};
                int count = 0;
                for (int k = g_.first[std::size_t(v)]; k < g_.first[std::size_t(v) + 1]; ++k) {
                    const int u = slot_[std::size_t(g_.neighbour[std::size_t(k)])];
                    if (u >= 0) {
                        sum = sum + foreseen(out, u, k, out.angle[s]);
                        ++count;
                    }
                }
                if (count) {
                    out.coords[s] = sum * (1.0f / float(count));
                }
            }
        }
        // Back to (0, 0) at the seed.
        const Vec2f middle = out.coords[0];
        for (Vec2f& c : out.coords) {
            c = c - middle;
        }
    }

    /// Stretch of the coordinates at each vertex, from the steps to its neighbours.
    void measure(Growth& out) const {
        const float most = std::log(kLargestStretch);
        out.strain.resize(out.vertices.size());
        int strained = 0;
        for (std::size_t s = 0; s < out.vertices.size(); ++s) {
            const int v = out.vertices[s];
            double m[3] = {0, 0, 0}, c[4] = {0, 0, 0, 0};
            int count = 0;
            for (int k = g_.first[std::size_t(v)]; k < g_.first[std::size_t(v) + 1]; ++k) {
                const int u = slot_[std::size_t(g_.neighbour[std::size_t(k)])];
                if (u >= 0) {
                    const Vec2f e = steps_.stepMm[std::size_t(k)], d = out.coords[std::size_t(u)] - out.coords[s];
                    m[0] += double(e.x * e.x);
                    m[1] += double(e.x * e.y);
                    m[2] += double(e.y * e.y);
                    c[0] += double(d.x * e.x);
                    c[1] += double(d.x * e.y);
                    c[2] += double(d.y * e.x);
                    c[3] += double(d.y * e.y);
                    ++count;
                }
            }
            const double det = m[0] * m[2] - m[1] * m[1];
            if (count < 2 || !(det > 1e-6 * (m[0] + m[2]) * (m[0] + m[2]))) {
                // Too few neighbours to tell, as at the chart's rim: what the chart's other vertices say holds here.
                out.strain[s] = count < 2 && out.vertices.size() > 8 ? 1e9f : 0.0f;
                continue;
            }
            const double a = (c[0] * m[2] - c[1] * m[1]) / det, b = (c[1] * m[0] - c[0] * m[1]) / det;
            const double e = (c[2] * m[2] - c[3] * m[1]) / det, f = (c[3] * m[0] - c[2] * m[1]) / det;
            // Singular values of [a b; e f].
            const double p = std::hypot(a + f, e - b) / 2, q = std::hypot(a - f, e + b) / 2;
            const double hi = p + q, lo = p - q;
            if (!(lo > 1e-3) || !(a * f - b * e > 0)) {
                out.strain[s] = 1e9f;
            } else {
                const float l1 = float(std::log(hi)), l2 = float(std::log(lo));
                out.strain[s] = std::abs(l1) > most || std::abs(l2) > most ? 1e9f : l1 * l1 + l2 * l2;
            }
            strained += out.strain[s] > 1e8f;
        }
        out.strainedShare = float(strained) / float(out.vertices.size());
    }

    const SurfaceGraph& g_;
    const SurfaceSteps& steps_;
    const std::vector<char>& singular_;
    std::vector<int> slot_; ///< of each vertex in the growing chart
    std::vector<int> touched_;
};

/// Vertices, in random order, that keep a distance from each other along the surface.
class PoissonDisk {
public:
    PoissonDisk(const SurfaceGraph& g, const SurfaceSteps& steps) : g_(g), steps_(steps), distance_(g.size(), 1e30f) {}

    std::vector<int> choose(const std::vector<int>& order, float spacing) {
        std::vector<int> seeds, touched;
        std::fill(distance_.begin(), distance_.end(), 1e30f);
        std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue;
        for (int s : order) {
            if (distance_[std::size_t(s)] < spacing) {
                continue;
            }
            seeds.push_back(s);
            distance_[std::size_t(s)] = 0;
            queue.push({0.0f, s});
            while (!queue.empty()) {
                const auto [d, v] = queue.top();
                queue.pop();
                if (d > distance_[std::size_t(v)]) {
                    continue;
                }
                for (int k = g_.first[std::size_t(v)]; k < g_.first[std::size_t(v) + 1]; ++k) {
                    const int u = g_.neighbour[std::size_t(k)];
                    const float next = d + norm(steps_.stepMm[std::size_t(k)]);
                    if (next < spacing && next < distance_[std::size_t(u)]) {
                        distance_[std::size_t(u)] = next;
                        queue.push({next, u});
                    }
                }
            }
        }
        return seeds;
    }

private:
    using Item = std::pair<float, int>;
    const SurfaceGraph& g_;
    const SurfaceSteps& steps_;
    std::vector<float> distance_;
};

/// Grows charts around seeds, in parallel.
std::vector<Growth> growAll(const SurfaceGraph& g, const SurfaceSteps& steps, const std::vector<char>& singular,
                            const std::vector<int>& seeds, float radius, bool rigid, std::vector<char>& isRigid,
                            Progress& progress) {
    std::vector<Growth> grown(seeds.size());
    isRigid.assign(seeds.size(), char(rigid));
    // A grower's scratch is as large as the surface: few of them.
    const std::size_t grain = std::max<std::size_t>(1, (seeds.size() + 31) / 32);
    std::atomic<std::size_t> done{0};
    parallelFor(seeds.size(), grain, [&](std::size_t begin, std::size_t end) {
        Grower grower(g, steps, singular);
        for (std::size_t i = begin; i < end; ++i) {
            grown[i] = grower.grow(seeds[i], radius, rigid);
            if (!rigid && (grown[i].metSingularity || grown[i].strainedShare > kStrainedShare)) {
                Growth again = grower.grow(seeds[i], radius, true);
                if (grown[i].metSingularity || again.strainedShare < grown[i].strainedShare) {
                    grown[i] = std::move(again);
                    isRigid[i] = 1;
                }
            }
            progress.update("charts", double(++done) / double(seeds.size()));
        }
    });
    return grown;
}

void assemble(std::size_t vertices, std::vector<Growth>& grown, ChartCover& cover) {
    cover.first.assign(vertices + 1, 0);
    for (const Growth& c : grown) {
        for (std::size_t i = 0; i < c.vertices.size(); ++i) {
            cover.first[std::size_t(c.vertices[i]) + 1] += c.strain[i] < 1e8f;
        }
    }
    for (std::size_t v = 0; v < vertices; ++v) {
        cover.first[v + 1] += cover.first[v];
    }
    const std::size_t entries = std::size_t(cover.first[vertices]);
    cover.chart.resize(entries);
    cover.coord.resize(entries);
    cover.remoteness.resize(entries);
    cover.strain.resize(entries);
    cover.member.reserve(entries);
    cover.entryOfMember.reserve(entries);
    std::vector<int> next(cover.first.begin(), cover.first.end() - 1);
    for (std::size_t c = 0; c < grown.size(); ++c) {
        Growth& from = grown[c];
        cover.charts[c].first = int(cover.member.size());
        for (std::size_t i = 0; i < from.vertices.size(); ++i) {
            if (from.strain[i] < 1e8f) {
                const std::size_t e = std::size_t(next[std::size_t(from.vertices[i])]++);
                cover.chart[e] = int(c);
                cover.coord[e] = from.coords[i];
                cover.remoteness[e] = from.distance[i] / std::max(1e-20f, cover.charts[c].radiusMm);
                cover.strain[e] = from.strain[i];
                cover.member.push_back(from.vertices[i]);
                cover.entryOfMember.push_back(int(e));
            }
        }
        cover.charts[c].count = int(cover.member.size()) - cover.charts[c].first;
        from = Growth();
    }
}

} // namespace

SurfaceSteps surfaceSteps(const SurfaceGraph& g, const std::vector<Vec3f>& directions, double mmPerUnit) {
    SurfaceSteps s;
    s.stepMm.resize(g.neighbour.size());
    s.turn.resize(g.neighbour.size());
    parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3d nv(g.normals[v]), xv(directions[v]), yv = cross(nv, xv);
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                const std::size_t u = std::size_t(g.neighbour[std::size_t(k)]);
                const Vec3d nu(g.normals[u]), xu(directions[u]), yu = cross(nu, xu);
                const Vec3d e = Vec3d(g.points[u]) - Vec3d(g.points[v]);
                // Both ends' frames, symmetrically, so that the way back is the opposite; of the length of the edge.
                const double x = dot(e, xv) + dot(e, xu), y = dot(e, yv) + dot(e, yu);
                const double l = std::hypot(x, y), scale = l > 0 ? length(e) * mmPerUnit / l : 0;
                s.stepMm[std::size_t(k)] = {float(x * scale), float(y * scale)};
                const Vec3d carried = carryTangent(xv, nv, nu);
                s.turn[std::size_t(k)] = float(std::atan2(dot(cross(carried, xu), nu), dot(carried, xu)));
            }
        }
    });
    s.wantedMm = s.stepMm;
    return s;
}

std::vector<float> scaleSteps(const SurfaceGraph& g, double rangeMm, double largest, double mmPerUnit,
                              SurfaceSteps& steps, Progress& progress) {
    // With the turning p X + q Y of the field (X, Y), exp(s) X and exp(s) Y are gradients where ds = -q X + p Y.
    std::vector<Vec2f> slope(g.size());
    parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            double m[3] = {0, 0, 0}, r[2] = {0, 0};
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                const Vec2f e = steps.stepMm[std::size_t(k)];
                const double turn = double(steps.turn[std::size_t(k)]);
                m[0] += double(e.x * e.x);
                m[1] += double(e.x * e.y);
                m[2] += double(e.y * e.y);
                r[0] += double(e.x) * turn;
                r[1] += double(e.y) * turn;
            }
            const double det = m[0] * m[2] - m[1] * m[1];
            if (det > 1e-3 * (m[0] + m[2]) * (m[0] + m[2])) {
                const double p = (r[0] * m[2] - r[1] * m[1]) / det, q = (r[1] * m[0] - r[0] * m[1]) / det;
                slope[v] = {float(-q), float(p)};
            }
        }
    });
    ConnectionEnergy energy;
    energy.first = g.first;
    energy.neighbour = g.neighbour;
    energy.link.assign(g.neighbour.size(), {1, 0});
    energy.diagonal.resize(g.size());
    energy.mass.resize(g.size());
    energy.wanted.resize(g.size());
    for (std::size_t v = 0; v < g.size(); ++v) {
        const double area = std::max(1e-300, double(g.area[v]));
        double sum = 0;
        for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
            const Vec2f e = steps.stepMm[std::size_t(k)],
                        s = (slope[v] + slope[std::size_t(g.neighbour[std::size_t(k)])]) * 0.5f;
            // At singularities the field turns without bound.
            const double d = double(e.x * s.x + e.y * s.y);
            sum -= std::clamp(d, -0.2, 0.2);
        }
        const double links = g.first[v + 1] - g.first[v];
        // Per link about a sixth of two areas' worth of gradient: the potential fades over the range.
        const double pull = 1.7 * area * mmPerUnit * mmPerUnit / (rangeMm * rangeMm);
        energy.diagonal[v] = links + pull + 1e-9;
        energy.mass[v] = area;
        energy.wanted[v] = sum;
    }
    const std::vector<std::complex<double>> z = minimize(std::move(energy), "scale", progress);
    std::vector<float> factor(g.size());
    const double most = std::log(largest);
    for (std::size_t v = 0; v < g.size(); ++v) {
        factor[v] = float(std::exp(most * std::tanh(z[v].real() / most)));
    }
    parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                steps.wantedMm[std::size_t(k)] =
                    steps.stepMm[std::size_t(k)] *
                    (0.5f * (factor[v] + factor[std::size_t(g.neighbour[std::size_t(k)])]));
            }
        }
    });
    return factor;
}

ChartCover coverByCharts(const SurfaceGraph& g, const SurfaceSteps& steps, const std::vector<char>& singular,
                         const ChartOptions& options, Progress& progress) {
    ChartCover cover;
    std::vector<Growth> all;
    std::vector<char> covered(g.size(), 0);
    PoissonDisk disk(g, steps);
    float spacing = float(options.spacingMm);
    for (int round = 0; round <= kRounds; ++round, spacing *= 0.5f) {
        std::vector<std::pair<std::uint32_t, int>> order;
        for (std::size_t v = 0; v < g.size(); ++v) {
            if (!covered[v]) {
                order.push_back({hash32(options.seed, (std::uint64_t(round) << 32) + v), int(v)});
            }
        }
        if (order.empty()) {
            break;
        }
        std::sort(order.begin(), order.end());
        std::vector<int> candidates;
        for (const auto& o : order) {
            candidates.push_back(o.second);
        }
        // The last round gives what is left a chart each.
        const float radius = round < kRounds ? float(options.reach) * spacing : 0.0f;
        const std::vector<int> seeds = round < kRounds ? disk.choose(candidates, spacing) : candidates;
        std::vector<char> rigid;
        std::vector<Growth> grown = growAll(g, steps, singular, seeds, radius, round > 0, rigid, progress);
        for (std::size_t i = 0; i < grown.size(); ++i) {
            if (round == kRounds) {
                grown[i].strain[0] = 0;
            }
            for (std::size_t k = 0; k < grown[i].vertices.size(); ++k) {
                covered[std::size_t(grown[i].vertices[k])] |= grown[i].strain[k] < 1e8f;
            }
            cover.charts.push_back({seeds[i], radius, rigid[i] != 0, 0, 0});
            all.push_back(std::move(grown[i]));
        }
    }
    assemble(g.size(), all, cover);
    return cover;
}

} // namespace stf
