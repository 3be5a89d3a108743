// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/synthesize.h"

#include "stfLib/base/parallel.h"
#include "stfLib/surface/split_edges.h"
#include "stfLib/synthesis/coherence_passes.h"
#include "stfLib/synthesis/heal_breaks.h"
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
constexpr double kEdgeTexels = 1.75;
constexpr double kLargestScale = 1.35;     ///< of the sample, up and down, so that patches fit together
constexpr double kScaleRange = 3;          ///< over how many patches the scale goes back to 1
constexpr std::size_t kLeastFragment = 24; ///< vertices: less is no patch but a flaw of one
constexpr double kHealedTexels = 8;        ///< breaks up to here are made up for by stretching

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

/// Derivative of the coordinates by steps in a vertex's frame, row by row, over the links that no seam crosses. Where
/// they are too few to tell, that of the chart over all links.
bool jacobian(const Synthesis& s, std::size_t v, double (&out)[4]) {
    for (int overChart = 0; overChart < 2; ++overChart) {
        const std::size_t entry = std::size_t(s.labels.entry[v]);
        double m[3] = {0, 0, 0}, c[4] = {0, 0, 0, 0};
        for (int k = s.graph.first[v]; k < s.graph.first[v + 1]; ++k) {
            Vec2f d = s.coords.delta[std::size_t(k)];
            if (overChart) {
                const int e = s.cover.entryAt(s.graph.neighbour[std::size_t(k)], s.cover.chart[entry]);
                if (e < 0) {
                    continue;
                }
                d = s.cover.coord[std::size_t(e)] - s.cover.coord[entry];
            } else if (s.coords.broken[std::size_t(k)]) {
                continue;
            }
            const Vec2f step = s.steps.stepMm[std::size_t(k)];
            m[0] += double(step.x * step.x);
            m[1] += double(step.x * step.y);
            m[2] += double(step.y * step.y);
            c[0] += double(d.x * step.x);
            c[1] += double(d.x * step.y);
            c[2] += double(d.y * step.x);
            c[3] += double(d.y * step.y);
        }
        const double det = m[0] * m[2] - m[1] * m[1];
        if (det > 1e-2 * (m[0] + m[2]) * (m[0] + m[2])) {
            out[0] = (c[0] * m[2] - c[1] * m[1]) / det;
            out[1] = (c[1] * m[0] - c[0] * m[1]) / det;
            out[2] = (c[2] * m[2] - c[3] * m[1]) / det;
            out[3] = (c[3] * m[0] - c[2] * m[1]) / det;
            if (out[0] * out[3] - out[1] * out[2] > 0.05) {
                return true;
            }
        }
    }
    out[0] = out[3] = 1;
    out[1] = out[2] = 0;
    return false;
}

/// The corner whose patch a triangle takes: one with the most unbroken sides.
int leadingCorner(const Synthesis& s, const Vec3i& t) {
    int unbroken[3] = {0, 0, 0};
    for (int c = 0; c < 3; ++c) {
        const int k = linkOf(s.graph, t[c], t[(c + 1) % 3]);
        if (k >= 0 && !s.coords.broken[std::size_t(k)]) {
            ++unbroken[c];
            ++unbroken[(c + 1) % 3];
        }
    }
    return int(std::max_element(unbroken, unbroken + 3) - unbroken);
}

double signedArea(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return double(b.x - a.x) * double(c.y - a.y) - double(b.y - a.y) * double(c.x - a.x);
}

} // namespace

RefinedSurface sampleSurface(RefinedSurface surface, double texelMm, double mmPerUnit, std::size_t maxTriangles,
                             const MessageSink& messages, SurfacePose* pose) {
    return splitLongEdges(std::move(surface), kEdgeTexels * texelMm / mmPerUnit, maxTriangles, messages, pose);
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
    const std::vector<char> singular = singularVertices(s.graph, s.singularities);
    const Vec2d tile = s.exemplar.tileMm();
    const double texel = std::max(s.exemplar.texelMm.x, s.exemplar.texelMm.y);
    ChartOptions charts;
    charts.seed = options.seed;
    charts.spacingMm =
        options.patchMm > 0 ? options.patchMm : std::max(kPatchShare * std::min(tile.x, tile.y), kLeastPatch * texel);
    s.patchMm = charts.spacingMm;
    scaleSteps(s.graph, kScaleRange * charts.spacingMm, kLargestScale, mmPerUnit, s.steps, progress);
    times.done("scale");
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
    absorbFragments(s.graph, s.cover, kLeastFragment, s.labels);
    times.done("coherence");
    // An eighth of the tile: more is another place.
    const double healed = std::min(kHealedTexels, std::min(s.exemplar.width, s.exemplar.height) / 8.0);
    s.coords = healBreaks(s.graph, s.steps, s.cover, s.exemplar, s.labels, std::max(1.0, healed), progress);
    times.done("healing");
    return s;
}

Vec2f patchTurn(const Synthesis& s, std::size_t v) {
    double j[4];
    jacobian(s, v, j);
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
    // Gradients per vertex, of what its own patch shows.
    std::vector<Vec3f> gradient[2];
    for (std::vector<Vec3f>& g : gradient) {
        g.resize(s.graph.size());
    }
    parallelFor(s.graph.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            double j[4];
            jacobian(s, v, j);
            const Vec3d n(s.graph.normals[v]), x(s.directions[v]), y = cross(n, x);
            gradient[0][v] = Vec3f((x * j[0] + y * j[1]) * s.mmPerUnit);
            gradient[1][v] = Vec3f((x * j[2] + y * j[3]) * s.mmPerUnit);
        }
    });
    parallelFor(s.graph.triangles.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const Vec3i& tri = s.graph.triangles[t];
            const int lead = leadingCorner(s, tri);
            const std::size_t l = std::size_t(tri[lead]);
            // Whole tiles are taken off per triangle: float then keeps its digits for the place within the tile.
            const Vec2f at = s.coords.coord[l];
            const Vec2f base{float(double(at.x) - std::floor(double(at.x) / map.tileMm.x) * map.tileMm.x),
                             float(double(at.y) - std::floor(double(at.y) / map.tileMm.y) * map.tileMm.y)};
            const Vec3d n(s.graph.normals[l]);
            Vec2f* const coords = &map.cornerCoords[3 * t];
            // Gradients turned into the plane of the facet, which on coarse meshes leans away from the vertices'
            // planes.
            const auto corner = [&](int c) { return Vec3d(s.graph.points[std::size_t(tri[c])]); };
            const Vec3d facet = normalize(cross(corner(1) - corner(0), corner(2) - corner(0)));
            const Vec3d plane = dot(facet, facet) > 0.5 ? facet : n;
            const Vec3d flatX = carryTangent(Vec3d(gradient[0][l]), n, plane),
                        flatY = carryTangent(Vec3d(gradient[1][l]), n, plane);
            const auto byGradient = [&](int c) {
                const Vec3d e = corner(c) - corner(lead);
                coords[c] = base + Vec2f(float(dot(flatX, e)), float(dot(flatY, e)));
            };
            for (int c = 0; c < 3; ++c) {
                const int k = c == lead ? -1 : linkOf(s.graph, int(l), tri[c]);
                const bool own = c == lead || (k >= 0 && !s.coords.broken[std::size_t(k)]);
                if (c == lead) {
                    coords[c] = base;
                } else if (own) {
                    coords[c] = base + s.coords.delta[std::size_t(k)];
                } else {
                    byGradient(c);
                }
                const std::size_t from = own ? std::size_t(tri[c]) : l;
                const Vec3d to(s.graph.normals[std::size_t(tri[c])]);
                for (int axis = 0; axis < 2; ++axis) {
                    const Vec3d v(gradient[axis][from]);
                    const Vec3d carried = own ? v : carryTangent(v, n, to);
                    (axis == 0 ? map.gradientX : map.gradientY)[3 * t + std::size_t(c)] = Vec3f(carried);
                }
            }
            if (!(signedArea(coords[0], coords[1], coords[2]) > 0)) {
                for (int c = 0; c < 3; ++c) {
                    byGradient(c);
                }
            }
        }
    });
    return map;
}

} // namespace stf
