// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/synthesize.h"

#include "stfLib/base/parallel.h"
#include "stfLib/surface/split_edges.h"
#include "stfLib/synthesis/coherence_passes.h"
#include "stfLib/synthesis/patch_offsets.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace stf {

namespace {

constexpr double kPatchShare = 0.6; ///< of the tile's shorter side, between the middles of patches
constexpr double kLeastPatch = 24;  ///< texels: smaller patches would be mostly seam
/// Longest edge in texels. Halves of right-angled triangles then have about one vertex per texel.
constexpr double kEdgeTexels = 1.5;

class StageTimes {
public:
    explicit StageTimes(std::vector<std::pair<std::string, double>>& out) : out_(out) {}
    void done(const char* stage) {
        const auto now = std::chrono::steady_clock::now();
        out_.push_back({stage, std::chrono::duration<double>(now - last_).count()});
        last_ = now;
    }

private:
    std::vector<std::pair<std::string, double>>& out_;
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Derivative of a chart's coordinates by steps in a vertex's frame, row by row; false where too few neighbours share
/// the chart.
bool jacobian(const Synthesis& s, std::size_t v, int chart, const Vec2f& at, double (&out)[4]) {
    double m[3] = {0, 0, 0}, c[4] = {0, 0, 0, 0};
    for (int k = s.graph.first[v]; k < s.graph.first[v + 1]; ++k) {
        const int e = s.cover.entryAt(s.graph.neighbour[std::size_t(k)], chart);
        if (e < 0) {
            continue;
        }
        const Vec2f step = s.steps.stepMm[std::size_t(k)], d = s.cover.coord[std::size_t(e)] - at;
        m[0] += double(step.x * step.x);
        m[1] += double(step.x * step.y);
        m[2] += double(step.y * step.y);
        c[0] += double(d.x * step.x);
        c[1] += double(d.x * step.y);
        c[2] += double(d.y * step.x);
        c[3] += double(d.y * step.y);
    }
    const double det = m[0] * m[2] - m[1] * m[1];
    if (!(det > 1e-4 * (m[0] + m[2]) * (m[0] + m[2]))) {
        return false;
    }
    out[0] = (c[0] * m[2] - c[1] * m[1]) / det;
    out[1] = (c[1] * m[0] - c[0] * m[1]) / det;
    out[2] = (c[2] * m[2] - c[3] * m[1]) / det;
    out[3] = (c[3] * m[0] - c[2] * m[1]) / det;
    return true;
}

/// The corner whose patch a triangle takes: of the patch that most corners have, else the one that reaches all.
int leadingCorner(const Synthesis& s, const Vec3i& t) {
    const auto same = [&](int a, int b) {
        const std::size_t u = std::size_t(t[a]), v = std::size_t(t[b]);
        return s.cover.chart[std::size_t(s.labels.entry[u])] == s.cover.chart[std::size_t(s.labels.entry[v])] &&
               s.labels.offset[u] == s.labels.offset[v];
    };
    if (same(0, 1) || same(0, 2)) {
        return 0;
    }
    if (same(1, 2)) {
        return 1;
    }
    for (int c = 0; c < 3; ++c) {
        const int chart = s.cover.chart[std::size_t(s.labels.entry[std::size_t(t[c])])];
        if (s.cover.entryAt(t[(c + 1) % 3], chart) >= 0 && s.cover.entryAt(t[(c + 2) % 3], chart) >= 0) {
            return c;
        }
    }
    return 0;
}

} // namespace

RefinedSurface sampleSurface(RefinedSurface surface, double texelMm, double mmPerUnit, std::size_t maxTriangles,
                             const MessageSink& messages) {
    return splitLongEdges(std::move(surface), kEdgeTexels * texelMm / mmPerUnit, maxTriangles, messages);
}

Synthesis synthesize(const RefinedSurface& surface, const BaseVolume& volume, double mmPerUnit,
                     const SynthesisOptions& options, Progress& progress) {
    if (!(mmPerUnit > 0) || !std::isfinite(mmPerUnit)) {
        throw Error("the scale of the tile is not positive");
    }
    if (surface.triangles.empty()) {
        throw Error("the surface has no triangles");
    }
    Synthesis s;
    s.mmPerUnit = mmPerUnit;
    StageTimes times(s.seconds);
    s.exemplar = makeExemplar(volume, options.response, progress);
    times.done("appearance");
    s.graph = surfaceGraph(surface);
    times.done("graph");
    std::vector<Vec3f> guide;
    if (!options.orientation.empty()) {
        if (options.orientation.size() != surface.points.size()) {
            throw Error("the tangent field does not have one vector per point");
        }
        guide.resize(s.graph.size());
        for (std::size_t i = 0; i < surface.points.size(); ++i) {
            guide[std::size_t(s.graph.vertexOfPoint[i])] += options.orientation[i];
        }
    }
    s.directions = smoothDirections(s.graph, guide, progress);
    s.singularities = singularities(s.graph, s.directions);
    times.done("directions");

    s.steps = surfaceSteps(s.graph, s.directions, mmPerUnit);
    std::vector<char> singular(s.graph.size(), 0);
    for (const Singularity& p : s.singularities) {
        for (int c = 0; c < 3; ++c) {
            singular[std::size_t(s.graph.triangles[std::size_t(p.triangle)][c])] = 1;
        }
    }
    const Vec2d tile = s.exemplar.tileMm();
    const double texel = std::max(s.exemplar.texelMm.x, s.exemplar.texelMm.y);
    ChartOptions charts;
    charts.seed = options.seed;
    charts.spacingMm =
        options.patchMm > 0 ? options.patchMm : std::max(kPatchShare * std::min(tile.x, tile.y), kLeastPatch * texel);
    s.patchMm = charts.spacingMm;
    s.cover = coverByCharts(s.graph, s.steps, singular, charts, progress);
    times.done("charts");

    OffsetOptions offsets;
    offsets.seed = options.seed;
    const std::vector<Vec2f> chosen = chooseOffsets(s.graph, s.cover, s.exemplar, mmPerUnit, offsets, progress);
    times.done("patches");
    s.labels = cutSeams(s.graph, s.cover, chosen, s.exemplar, {}, progress);
    times.done("seams");
    CoherenceOptions coherence;
    coherence.seed = options.seed;
    correctByCoherence(s.graph, s.steps, s.cover, s.exemplar, coherence, s.labels, progress);
    times.done("coherence");
    return s;
}

Vec2f patchTurn(const Synthesis& s, std::size_t v) {
    const std::size_t entry = std::size_t(s.labels.entry[v]);
    double j[4] = {1, 0, 0, 1};
    jacobian(s, v, s.cover.chart[entry], s.cover.coord[entry], j);
    // The rotation nearest to the derivative.
    const double x = j[0] + j[3], y = j[2] - j[1], l = std::hypot(x, y);
    return l > 0 ? Vec2f(float(x / l), float(y / l)) : Vec2f(1, 0);
}

ExemplarMap exemplarMap(const Synthesis& s) {
    ExemplarMap map;
    map.tileMm = s.exemplar.tileMm();
    char text[200];
    std::snprintf(text, sizeof text, "synthesised: %zu samples, %zu charts of %.3g mm, %zu singularities",
                  s.graph.size(), s.cover.charts.size(), s.patchMm, s.singularities.size());
    map.description = text;
    const std::size_t corners = 3 * s.graph.triangles.size();
    map.cornerCoords.resize(corners);
    map.gradientX.resize(corners);
    map.gradientY.resize(corners);
    parallelFor(s.graph.triangles.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const Vec3i& tri = s.graph.triangles[t];
            const int lead = leadingCorner(s, tri);
            const std::size_t l = std::size_t(tri[lead]);
            const int chart = s.cover.chart[std::size_t(s.labels.entry[l])];
            const Vec2f offset = s.labels.offset[l];
            // Whole tiles are taken off per triangle: float then keeps its digits for the place within the tile.
            const Vec2f at = s.labels.coord(s.cover, l);
            const Vec2f whole{float(std::floor(double(at.x) / map.tileMm.x) * map.tileMm.x),
                              float(std::floor(double(at.y) / map.tileMm.y) * map.tileMm.y)};
            for (int c = 0; c < 3; ++c) {
                const std::size_t v = std::size_t(tri[c]), i = 3 * t + std::size_t(c);
                const int e = s.cover.entryAt(tri[c], chart);
                double j[4] = {1, 0, 0, 1};
                std::size_t frame = v;
                if (e >= 0) {
                    map.cornerCoords[i] = s.cover.coord[std::size_t(e)] + offset - whole;
                    jacobian(s, v, chart, s.cover.coord[std::size_t(e)], j);
                } else {
                    // By the gradient at the corner that leads.
                    jacobian(s, l, chart, s.cover.coord[std::size_t(s.labels.entry[l])], j);
                    frame = l;
                    Vec2f step{0, 0};
                    for (int k = s.graph.first[l]; k < s.graph.first[l + 1]; ++k) {
                        step = s.graph.neighbour[std::size_t(k)] == tri[c] ? s.steps.stepMm[std::size_t(k)] : step;
                    }
                    map.cornerCoords[i] = at - whole + Vec2f(float(j[0]) * step.x + float(j[1]) * step.y,
                                                             float(j[2]) * step.x + float(j[3]) * step.y);
                }
                const Vec3d n(s.graph.normals[frame]), x(s.directions[frame]), y = cross(n, x);
                map.gradientX[i] = Vec3f((x * j[0] + y * j[1]) * s.mmPerUnit);
                map.gradientY[i] = Vec3f((x * j[2] + y * j[3]) * s.mmPerUnit);
            }
        }
    });
    return map;
}

} // namespace stf
