// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/blend_map.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/surface/direction_field.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace stf {

namespace {

constexpr double kSpacing = 0.4; ///< of the tile's shorter side, between the middles of charts
constexpr double kReach = 1.6;   ///< so that two or three charts lie over most of the surface
/// Places that stretch more than this against each other are not blended.
constexpr double kLargestStretch = 3;

/// Weights of the charts at a vertex, by entry: at most three are above 0, all are 0 where their chart ends.
class VertexWeights {
public:
    VertexWeights(const ChartCover& cover, std::size_t vertices) : weight_(cover.chart.size(), 0.0f) {
        parallelFor(vertices, 4096, [&](std::size_t begin, std::size_t end) {
            std::vector<float> hats;
            for (std::size_t v = begin; v < end; ++v) {
                const int a = cover.first[v], b = cover.first[v + 1];
                hats.clear();
                for (int e = a; e < b; ++e) {
                    const float r = std::min(1.0f, cover.remoteness[std::size_t(e)]);
                    hats.push_back((1 - r * r) * (1 - r * r) + 1e-6f * (b - a == 1));
                }
                std::vector<float>& sorted = hats;
                std::copy(hats.begin(), hats.end(), weight_.begin() + a);
                std::sort(sorted.begin(), sorted.end(), std::greater<float>());
                // Less the fourth: who comes or goes has no weight then.
                const float fourth = sorted.size() > 3 ? sorted[3] : 0.0f;
                for (int e = a; e < b; ++e) {
                    weight_[std::size_t(e)] = std::max(0.0f, weight_[std::size_t(e)] - fourth);
                }
            }
        });
    }
    float operator[](int entry) const { return weight_[std::size_t(entry)]; }

private:
    std::vector<float> weight_;
};

/// A chart at the corners of a triangle.
struct Candidate {
    int chart = -1;
    int entry[3] = {-1, -1, -1}; ///< -1: it does not reach that corner
    float weight[3] = {0, 0, 0};
    Vec2f coord[3];
    float total() const { return weight[0] + weight[1] + weight[2]; }
    bool whole() const { return entry[0] >= 0 && entry[1] >= 0 && entry[2] >= 0; }
};

class TriangleBlends {
public:
    TriangleBlends(const SurfaceGraph& graph, const std::vector<Vec3f>& directions, const ChartCover& cover,
                   const Vec2d& tileMm, double mmPerUnit, std::uint64_t seed)
        : graph_(graph), directions_(directions), cover_(cover), weights_(cover, graph.size()), mmPerUnit_(mmPerUnit) {
        offset_.reserve(cover.charts.size());
        for (std::size_t c = 0; c < cover.charts.size(); ++c) {
            CounterRng rng(seed ^ 0x626c656e64, c);
            offset_.push_back({float(double(rng.uniform()) * tileMm.x), float(double(rng.uniform()) * tileMm.y)});
        }
    }

    TriangleBlend make(std::size_t t, Vec2f (&coords)[3]) const {
        const Vec3i& tri = graph_.triangles[t];
        std::vector<Candidate> candidates = candidatesOf(tri);
        // The first place must be known at all corners, and lie the right way up.
        const auto better = [](const Candidate& a, const Candidate& b) {
            return a.whole() != b.whole()   ? a.whole()
                   : a.total() != b.total() ? a.total() > b.total()
                                            : a.chart < b.chart;
        };
        std::sort(candidates.begin(), candidates.end(), better);
        for (Candidate& c : candidates) {
            if (c.whole() && area(c.coord) > 0) {
                std::swap(c, candidates.front());
                break;
            }
        }
        TriangleBlend blend;
        Candidate& first = candidates.front();
        if (!first.whole() || !(area(first.coord) > 0)) {
            unroll(tri, first);
            candidates.erase(candidates.begin() + 1, candidates.end());
        }
        std::copy(first.coord, first.coord + 3, coords);
        blend.base = first.coord[0];
        const Vec2f e1 = first.coord[1] - first.coord[0], e2 = first.coord[2] - first.coord[0];
        const double det = double(e1.x) * double(e2.y) - double(e1.y) * double(e2.x);
        if (!(std::abs(det) > 0)) {
            return blend;
        }
        // The gradient, over the first place, of what is 0, a, b at the corners.
        const auto gradient = [&](double a, double b) {
            return Vec2f(float((a * double(e2.y) - b * double(e1.y)) / det),
                         float((b * double(e1.x) - a * double(e2.x)) / det));
        };
        std::array<const Candidate*, 3> used{&first, nullptr, nullptr};
        std::size_t count = 1;
        std::sort(candidates.begin() + 1, candidates.end(), [](const Candidate& a, const Candidate& b) {
            return a.total() != b.total() ? a.total() > b.total() : a.chart < b.chart;
        });
        for (std::size_t i = 1; i < candidates.size() && count < 3; ++i) {
            Candidate& c = candidates[i];
            if (!(c.total() > 0)) {
                break;
            }
            continueBeyond(first, c);
            const Vec2f gx = gradient(double(c.coord[1].x - c.coord[0].x), double(c.coord[2].x - c.coord[0].x));
            const Vec2f gy = gradient(double(c.coord[1].y - c.coord[0].y), double(c.coord[2].y - c.coord[0].y));
            const double turned = double(gx.x) * double(gy.y) - double(gx.y) * double(gy.x);
            const double spread =
                std::hypot(std::hypot(double(gx.x), double(gx.y)), std::hypot(double(gy.x), double(gy.y)));
            if (!(turned > 1 / (kLargestStretch * kLargestStretch)) || !(spread < 1.42 * kLargestStretch)) {
                continue;
            }
            blend.other[count - 1] = c.coord[0];
            blend.across[count - 1] = {Vec2f(gx.x, gy.x), Vec2f(gx.y, gy.y)};
            used[count++] = &c;
        }
        float sum[3];
        for (int c = 0; c < 3; ++c) {
            sum[c] = 0;
            for (std::size_t k = 0; k < count; ++k) {
                sum[c] += used[k]->weight[c];
            }
        }
        for (std::size_t k = 0; k < 3; ++k) {
            float w[3];
            for (int c = 0; c < 3; ++c) {
                // Where none of them counts, the first does.
                w[c] = sum[c] > 0 ? (k < count ? used[k]->weight[c] / sum[c] : 0.0f) : float(k == 0);
            }
            blend.weight[k] = w[0];
            blend.slope[k] = gradient(double(w[1] - w[0]), double(w[2] - w[0]));
        }
        return blend;
    }

private:
    static double area(const Vec2f (&c)[3]) {
        return double(c[1].x - c[0].x) * double(c[2].y - c[0].y) - double(c[1].y - c[0].y) * double(c[2].x - c[0].x);
    }

    std::vector<Candidate> candidatesOf(const Vec3i& tri) const {
        std::vector<Candidate> out;
        for (int c = 0; c < 3; ++c) {
            const std::size_t v = std::size_t(tri[c]);
            for (int e = cover_.first[v]; e < cover_.first[v + 1]; ++e) {
                const int chart = cover_.chart[std::size_t(e)];
                auto it = std::find_if(out.begin(), out.end(), [&](const Candidate& k) { return k.chart == chart; });
                if (it == out.end()) {
                    it = out.insert(out.end(), Candidate());
                    it->chart = chart;
                }
                it->entry[c] = e;
                it->weight[c] = weights_[e];
                it->coord[c] = cover_.coord[std::size_t(e)] + offset_[std::size_t(chart)];
            }
        }
        return out;
    }

    /// Coordinates at all corners by the frame of one that the chart holds.
    void unroll(const Vec3i& tri, Candidate& c) const {
        const int lead = int(std::find_if(c.entry, c.entry + 3, [](int e) { return e >= 0; }) - c.entry);
        const std::size_t v = std::size_t(tri[lead]);
        const Vec3d n(graph_.normals[v]), x(directions_[v]), y = cross(n, x);
        for (int k = 0; k < 3; ++k) {
            const Vec3d e = Vec3d(graph_.points[std::size_t(tri[k])]) - Vec3d(graph_.points[v]);
            c.coord[k] = c.coord[lead] + Vec2f(float(dot(e, x) * mmPerUnit_), float(dot(e, y) * mmPerUnit_));
        }
    }

    /// Where a chart does not reach a corner (its weight is 0 there), it goes on as the first place does.
    static void continueBeyond(const Candidate& first, Candidate& c) {
        const int known = int(std::find_if(c.entry, c.entry + 3, [](int e) { return e >= 0; }) - c.entry);
        for (int k = 0; k < 3; ++k) {
            if (c.entry[k] < 0) {
                c.coord[k] = c.coord[known] + (first.coord[k] - first.coord[known]);
            }
        }
    }

    const SurfaceGraph& graph_;
    const std::vector<Vec3f>& directions_;
    const ChartCover& cover_;
    VertexWeights weights_;
    double mmPerUnit_;
    std::vector<Vec2f> offset_; ///< which part of the sample a chart shows, mm
};

} // namespace

BlendMap blendMap(const RefinedSurface& surface, const Vec2d& tileMm, double mmPerUnit, std::uint64_t seed,
                  Progress& progress) {
    if (!(mmPerUnit > 0) || !std::isfinite(mmPerUnit)) {
        throw Error("the scale of the tile is not positive");
    }
    if (surface.triangles.empty()) {
        throw Error("the surface has no triangles");
    }
    const SurfaceGraph graph = surfaceGraph(surface);
    const std::vector<Vec3f> directions = smoothDirections(graph, {}, progress);
    const std::vector<char> singular = singularVertices(graph, singularities(graph, directions));
    SurfaceSteps steps = surfaceSteps(graph, directions, mmPerUnit);
    ChartOptions options;
    options.spacingMm = kSpacing * std::min(tileMm.x, tileMm.y);
    options.reach = kReach;
    options.seed = seed;
    const ChartCover cover = coverByCharts(graph, steps, singular, options, progress);
    const TriangleBlends blends(graph, directions, cover, tileMm, mmPerUnit, seed);

    BlendMap map;
    map.first.tileMm = tileMm;
    const std::size_t n = surface.triangles.size();
    map.triangles.resize(n);
    map.first.cornerCoords.resize(3 * n);
    map.first.gradientX.resize(3 * n);
    map.first.gradientY.resize(3 * n);
    parallelFor(n, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            Vec2f coords[3];
            map.triangles[t] = blends.make(t, coords);
            const Vec3i& tri = graph.triangles[t];
            const Vec3d p(graph.points[std::size_t(tri.x)]);
            const Vec3d e1 = Vec3d(graph.points[std::size_t(tri.y)]) - p,
                        e2 = Vec3d(graph.points[std::size_t(tri.z)]) - p;
            const Vec3d normal = cross(e1, e2);
            const double square = dot(normal, normal);
            // Gradients over the facet, carried to the planes of its corners.
            const Vec3d a = square > 0 ? cross(e2, normal) / square : Vec3d(0.0);
            const Vec3d b = square > 0 ? cross(normal, e1) / square : Vec3d(0.0);
            const Vec3d gx = a * double(coords[1].x - coords[0].x) + b * double(coords[2].x - coords[0].x);
            const Vec3d gy = a * double(coords[1].y - coords[0].y) + b * double(coords[2].y - coords[0].y);
            for (int c = 0; c < 3; ++c) {
                const std::size_t k = 3 * t + std::size_t(c);
                map.first.cornerCoords[k] = coords[c];
                const Vec3d corner(graph.normals[std::size_t(tri[c])]);
                map.first.gradientX[k] = Vec3f(square > 0 ? carryTangent(gx, normalize(normal), corner) : gx);
                map.first.gradientY[k] = Vec3f(square > 0 ? carryTangent(gy, normalize(normal), corner) : gy);
            }
        }
    });
    char text[120];
    std::snprintf(text, sizeof text, "blended: %zu overlapping places of %.3g mm", cover.charts.size(),
                  2 * kReach * options.spacingMm);
    map.first.description = text;
    return map;
}

PlacesAt placesAt(const TriangleBlend& t, const Vec2f& coord, const Vec2f& tile) {
    const auto nearest = [](float d, float period) { return d - period * std::nearbyint(d / period); };
    const Vec2f d{nearest(coord.x - t.base.x, tile.x), nearest(coord.y - t.base.y, tile.y)};
    PlacesAt out;
    float sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        out.weight[k] = std::max(0.0f, t.weight[k] + t.slope[k].x * d.x + t.slope[k].y * d.y);
        sum += out.weight[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
        out.weight[k] = sum > 0 ? out.weight[k] / sum : float(k == 0);
    }
    for (std::size_t i = 0; i < 2; ++i) {
        out.other[i] = t.other[i] + t.across[i][0] * d.x + t.across[i][1] * d.y;
    }
    return out;
}

} // namespace stf
