// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/surface_graph.h"

#include "stfLib/base/parallel.h"

#include <algorithm>
#include <numeric>

namespace stf {

namespace {

/// Numbers distinct positions in the order of their first points.
std::size_t weld(const std::vector<Vec3f>& points, std::vector<int>& vertexOfPoint) {
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int i) {
        const Vec3f& p = points[std::size_t(i)];
        return std::tuple(p.x, p.y, p.z, i);
    };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
    std::vector<int> head(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && points[std::size_t(order[i])] == points[std::size_t(order[i - 1])];
        head[std::size_t(order[i])] = same ? head[std::size_t(order[i - 1])] : order[i];
    }
    vertexOfPoint.resize(points.size());
    int count = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        vertexOfPoint[i] = head[i] == int(i) ? count++ : vertexOfPoint[std::size_t(head[i])];
    }
    return std::size_t(count);
}

} // namespace

double SurfaceGraph::totalArea() const {
    double sum = 0;
    for (float a : area) {
        sum += double(a);
    }
    return sum;
}

SurfaceGraph surfaceGraph(const RefinedSurface& surface) {
    SurfaceGraph g;
    const std::size_t n = weld(surface.points, g.vertexOfPoint);
    g.points.resize(n);
    std::vector<Vec3d> normal(n), facet(n);
    for (std::size_t i = 0; i < surface.points.size(); ++i) {
        const std::size_t v = std::size_t(g.vertexOfPoint[i]);
        g.points[v] = surface.points[i];
        normal[v] += Vec3d(surface.normals[i]);
    }
    g.area.assign(n, 0);
    g.triangles.reserve(surface.triangles.size());
    std::vector<int> count(n + 1, 0);
    for (const Vec3i& t : surface.triangles) {
        const Vec3i q(g.vertexOfPoint[std::size_t(t.x)], g.vertexOfPoint[std::size_t(t.y)],
                      g.vertexOfPoint[std::size_t(t.z)]);
        g.triangles.push_back(q);
        const Vec3d p(g.points[std::size_t(q.x)]);
        const Vec3d cr = cross(Vec3d(g.points[std::size_t(q.y)]) - p, Vec3d(g.points[std::size_t(q.z)]) - p);
        for (int c = 0; c < 3; ++c) {
            g.area[std::size_t(q[c])] += float(length(cr) / 6);
            facet[std::size_t(q[c])] += cr;
            count[std::size_t(q[c])] += 2;
        }
    }
    g.normals.resize(n);
    for (std::size_t v = 0; v < n; ++v) {
        // Of a faceted surface, shared normals say where the shell lies, not where the surface does; and normals of a
        // cut's two sides may cancel. Then the facets say where outside is.
        const bool smooth = surface.cornerNormals.empty() && length(normal[v]) > 1e-3;
        const Vec3d m = smooth || !(length(facet[v]) > 0) ? normal[v] : facet[v];
        g.normals[v] = length(m) > 0 ? Vec3f(normalize(m)) : Vec3f(0, 0, 1);
    }
    std::vector<std::size_t> begin(n + 1, 0);
    for (std::size_t v = 0; v < n; ++v) {
        begin[v + 1] = begin[v] + std::size_t(count[v]);
    }
    std::vector<int> all(begin[n]);
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (const Vec3i& t : g.triangles) {
        for (int c = 0; c < 3; ++c) {
            all[next[std::size_t(t[c])]++] = t[(c + 1) % 3];
            all[next[std::size_t(t[c])]++] = t[(c + 2) % 3];
        }
    }
    parallelFor(n, 4096, [&](std::size_t b, std::size_t e) {
        for (std::size_t v = b; v < e; ++v) {
            const auto from = all.begin() + std::ptrdiff_t(begin[v]), to = all.begin() + std::ptrdiff_t(begin[v + 1]);
            std::sort(from, to);
            const auto end = std::remove(from, std::unique(from, to), int(v));
            count[v] = int(end - from);
        }
    });
    g.first.assign(n + 1, 0);
    for (std::size_t v = 0; v < n; ++v) {
        g.first[v + 1] = g.first[v] + count[v];
    }
    g.neighbour.resize(std::size_t(g.first[n]));
    for (std::size_t v = 0; v < n; ++v) {
        std::copy_n(all.begin() + std::ptrdiff_t(begin[v]), count[v], g.neighbour.begin() + g.first[v]);
    }
    return g;
}

int linkOf(const SurfaceGraph& g, int u, int v) {
    const auto begin = g.neighbour.begin() + g.first[std::size_t(u)],
               end = g.neighbour.begin() + g.first[std::size_t(u) + 1];
    const auto it = std::lower_bound(begin, end, v);
    return it != end && *it == v ? int(it - g.neighbour.begin()) : -1;
}

std::vector<float> cotangentWeights(const SurfaceGraph& g) {
    std::vector<float> weight(g.neighbour.size(), 0);
    for (const Vec3i& t : g.triangles) {
        if (t.x == t.y || t.y == t.z || t.z == t.x) {
            continue;
        }
        for (int c = 0; c < 3; ++c) {
            const int a = t[(c + 1) % 3], b = t[(c + 2) % 3];
            const Vec3d p(g.points[std::size_t(t[c])]);
            const Vec3d u = Vec3d(g.points[std::size_t(a)]) - p, v = Vec3d(g.points[std::size_t(b)]) - p;
            const double area2 = length(cross(u, v));
            const float w = area2 > 0 ? float(std::clamp(0.5 * dot(u, v) / area2, -2.0, 2.0)) : 0.0f;
            weight[std::size_t(linkOf(g, a, b))] += w;
            weight[std::size_t(linkOf(g, b, a))] += w;
        }
    }
    for (float& w : weight) {
        w = std::max(0.05f, w);
    }
    return weight;
}

} // namespace stf
