// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_edges.h"

#include "stfLib/base/parallel_sort.h"

#include <cstring>

namespace stf {

namespace {

constexpr double kJump = 1e-3;       ///< of the tile: coordinates that differ by more do not continue each other
constexpr float kSharpCosine = 0.7f; ///< shading normals that differ by more make a hard edge

struct Edge {
    std::uint64_t key; ///< hash of both positions, whatever their order
    std::uint32_t triangle;
    std::uint8_t corner; ///< the edge starts there
    bool operator<(const Edge& o) const {
        return key != o.key ? key < o.key : triangle != o.triangle ? triangle < o.triangle : corner < o.corner;
    }
};

std::uint64_t mix(std::uint64_t h) {
    h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9u;
    h = (h ^ h >> 27) * 0x94d049bb133111ebu;
    return h ^ h >> 31;
}

std::uint64_t hashOf(const Vec3f& p) {
    const Vec3f positive = p + Vec3f(0.0f); // -0 and 0 are one place
    std::uint32_t bits[3];
    std::memcpy(bits, &positive, sizeof bits);
    return mix(mix(mix(bits[0]) ^ bits[1]) ^ bits[2]);
}

/// Whether both representatives modulo the tile are the same place.
bool same(double a, double b, double tile) {
    const double d = a - b;
    return std::abs(d - tile * std::round(d / tile)) <= kJump * tile;
}

class EdgeReader {
public:
    EdgeReader(const RefinedSurface& s, const ExemplarMap& m) : surface_(s), map_(m) {}

    int index(const Edge& e, int end) const { return surface_.triangles[e.triangle][(e.corner + end) % 3]; }
    Vec3f point(const Edge& e, int end) const { return surface_.points[std::size_t(index(e, end))]; }
    Vec3f normal(const Edge& e, int end) const {
        const std::size_t c = std::size_t(e.corner + end) % 3;
        return surface_.cornerNormals.empty() ? surface_.normals[std::size_t(surface_.triangles[e.triangle][int(c)])]
                                              : surface_.cornerNormals[3 * e.triangle + c];
    }
    Vec2f coords(const Edge& e, int end) const {
        return map_.cornerCoords[3 * e.triangle + std::size_t(e.corner + end) % 3];
    }
    bool isSeam(const Edge& a, const Edge& b, bool opposed) const {
        for (int end = 0; end < 2; ++end) {
            const int other = opposed ? 1 - end : end;
            const Vec2f x = coords(a, end), y = coords(b, other);
            if (!same(double(x.x), double(y.x), map_.tileMm.x) || !same(double(x.y), double(y.y), map_.tileMm.y) ||
                dot(normal(a, end), normal(b, other)) < kSharpCosine) {
                return true;
            }
        }
        return false;
    }

private:
    const RefinedSurface& surface_;
    const ExemplarMap& map_;
};

} // namespace

ShellEdges findEdges(const RefinedSurface& surface, const ExemplarMap& map) {
    std::vector<Edge> edges;
    edges.reserve(3 * surface.triangles.size());
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const Vec3i& tri = surface.triangles[t];
        const Vec3f p[3] = {surface.points[std::size_t(tri.x)], surface.points[std::size_t(tri.y)],
                            surface.points[std::size_t(tri.z)]};
        if (!(length(cross(Vec3d(p[1]) - Vec3d(p[0]), Vec3d(p[2]) - Vec3d(p[0]))) > 0)) {
            continue;
        }
        const std::uint64_t h[3] = {hashOf(p[0]), hashOf(p[1]), hashOf(p[2])};
        for (int c = 0; c < 3; ++c) {
            edges.push_back({h[c] + h[(c + 1) % 3], std::uint32_t(t), std::uint8_t(c)});
        }
    }
    parallelSort(edges.begin(), edges.end());
    ShellEdges out;
    const EdgeReader read(surface, map);
    for (std::size_t i = 0, end; i < edges.size(); i = end) {
        for (end = i + 1; end < edges.size() && edges[end].key == edges[i].key; ++end) {
        }
        const Edge& a = edges[i];
        const double l = double(length(read.point(a, 1) - read.point(a, 0)));
        if (end - i == 1) {
            ++out.rims;
            out.rimLength += l;
            continue;
        }
        out.crowded += end - i > 2;
        for (std::size_t k = i + 1; k < end; ++k) {
            const bool opposed = read.point(a, 0) == read.point(edges[k], 1);
            out.turned += end - i == 2 && !opposed;
            if (read.isSeam(a, edges[k], opposed)) {
                out.seams.push_back({read.index(a, 0), read.index(a, 1)});
                out.seamLength += l;
                break;
            }
        }
    }
    return out;
}

} // namespace stf
