// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/heal_breaks.h"

#include "stfLib/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr int kSweeps = 160;
constexpr float kStiffness = 0.004f; ///< of staying in place against agreeing: shifts fade over some 15 links

bool samePatch(const ChartCover& cover, const PatchLabels& l, std::size_t u, std::size_t v) {
    return cover.chart[std::size_t(l.entry[u])] == cover.chart[std::size_t(l.entry[v])] && l.offset[u] == l.offset[v];
}

float norm(const Vec2f& v) {
    return std::sqrt(v.x * v.x + v.y * v.y);
}

} // namespace

SurfaceCoords healBreaks(const SurfaceGraph& g, const SurfaceSteps& steps, const ChartCover& cover, const Exemplar& ex,
                         const PatchLabels& labels, double limitTexels, Progress& progress) {
    const float texel = float(std::max(ex.texelMm.x, ex.texelMm.y));
    const float limit = float(limitTexels) * texel;
    const Vec2d tile = ex.tileMm();
    SurfaceCoords out;
    out.delta.resize(g.neighbour.size());
    out.broken.assign(g.neighbour.size(), 0);
    // Per link: the step that both ends' patches foresee, and by how much what is shown differs from it.
    std::vector<Vec2f> excess(g.neighbour.size());
    std::vector<float> weight(g.neighbour.size());
    parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vec2f here = labels.coord(cover, v);
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                const std::size_t u = std::size_t(g.neighbour[std::size_t(k)]), s = std::size_t(k);
                const Vec2f there = labels.coord(cover, u);
                if (samePatch(cover, labels, u, v)) {
                    out.delta[s] = there - here;
                    excess[s] = {0, 0};
                    weight[s] = 1;
                    continue;
                }
                const Vec2f onward = continued(cover, labels, v, u, steps.stepMm[s]) - here;
                const Vec2f back = there - continued(cover, labels, u, v, steps.stepMm[s] * -1.0f);
                const Vec2f step = (onward + back) * 0.5f;
                excess[s] = nearestImage(there - here - step, tile);
                out.delta[s] = step;
                const float r = norm(excess[s]) / limit;
                // Patches that do not even agree on the step are no continuation of each other.
                const bool agree = norm(onward - back) < norm(steps.stepMm[s]);
                weight[s] = r < 1 && agree ? (1 - r * r) * (1 - r * r) : 0.0f;
            }
        }
    });
    // Shifts that make c_u + shift_u = c_v + shift_v + step: each vertex takes what its neighbours ask for, all at
    // once.
    std::vector<Vec2f> shift(g.size()), next(g.size());
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                Vec2f sum{0, 0};
                float total = kStiffness;
                for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                    const std::size_t s = std::size_t(k);
                    sum = sum + (shift[std::size_t(g.neighbour[s])] + excess[s]) * weight[s];
                    total += weight[s];
                }
                next[v] = shift[v] * 0.2f + sum * (0.8f / total);
            }
        });
        shift.swap(next);
        progress.update("healing", double(sweep + 1) / kSweeps);
    }
    out.coord.resize(g.size());
    for (std::size_t v = 0; v < g.size(); ++v) {
        out.coord[v] = labels.coord(cover, v) + shift[v];
    }
    parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                const std::size_t s = std::size_t(k), u = std::size_t(g.neighbour[s]);
                const Vec2f left = excess[s] + shift[u] - shift[v];
                out.broken[s] = !(weight[s] > 0) || norm(left) > texel;
                // What is left of a healed break is stretch of the link.
                out.delta[s] = out.broken[s] ? out.delta[s] : out.delta[s] + left;
            }
        }
    });
    // A link is broken for both its ends or for none: they may round differently.
    for (std::size_t v = 0; v < g.size(); ++v) {
        for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
            if (out.broken[std::size_t(k)]) {
                out.broken[std::size_t(linkOf(g, g.neighbour[std::size_t(k)], int(v)))] = 1;
            }
        }
    }
    return out;
}

void absorbFragments(const SurfaceGraph& g, const ChartCover& cover, std::size_t least, PatchLabels& labels) {
    std::vector<char> seen(g.size(), 0);
    std::vector<int> part;
    for (std::size_t start = 0; start < g.size(); ++start) {
        if (seen[start]) {
            continue;
        }
        part.assign(1, int(start));
        seen[start] = 1;
        for (std::size_t i = 0; i < part.size(); ++i) {
            const std::size_t v = std::size_t(part[i]);
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                const std::size_t u = std::size_t(g.neighbour[std::size_t(k)]);
                if (!seen[u] && samePatch(cover, labels, u, v)) {
                    seen[u] = 1;
                    part.push_back(int(u));
                }
            }
        }
        if (part.size() >= least) {
            continue;
        }
        // Patches around, each with how many links lead to it.
        std::vector<std::pair<int, int>> around; // a vertex of the patch, count
        for (int p : part) {
            const std::size_t v = std::size_t(p);
            for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
                const int u = g.neighbour[std::size_t(k)];
                if (samePatch(cover, labels, std::size_t(u), v)) {
                    continue;
                }
                const auto it = std::find_if(around.begin(), around.end(), [&](const auto& a) {
                    return samePatch(cover, labels, std::size_t(a.first), std::size_t(u));
                });
                if (it == around.end()) {
                    around.push_back({u, 1});
                } else {
                    ++it->second;
                }
            }
        }
        std::stable_sort(around.begin(), around.end(),
                         [](const auto& a, const auto& b) { return a.second > b.second; });
        for (const auto& [vertex, count] : around) {
            const int chart = cover.chart[std::size_t(labels.entry[std::size_t(vertex)])];
            if (std::all_of(part.begin(), part.end(), [&](int p) { return cover.entryAt(p, chart) >= 0; })) {
                const Vec2f offset = labels.offset[std::size_t(vertex)];
                for (int p : part) {
                    labels.entry[std::size_t(p)] = cover.entryAt(p, chart);
                    labels.offset[std::size_t(p)] = offset;
                }
                break;
            }
        }
    }
}

} // namespace stf
