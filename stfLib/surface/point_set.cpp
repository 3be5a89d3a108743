// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/point_set.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace stf {

namespace {

constexpr float largestCoordinate = 1e18f; // as of meshes: beyond it a square is no float any more
constexpr int coarsest = -2, finest = 3;   // how often an icosahedron is split; -1: not, -2: an octahedron

struct Polyhedron {
    std::vector<Vec3d> points; ///< unit
    std::vector<Vec3i> triangles;
};

Polyhedron octahedron() {
    return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
            {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

Polyhedron icosahedron() {
    const double g = (1 + std::sqrt(5.0)) / 2;
    Polyhedron p = {{{-1, g, 0},
                     {1, g, 0},
                     {-1, -g, 0},
                     {1, -g, 0},
                     {0, -1, g},
                     {0, 1, g},
                     {0, -1, -g},
                     {0, 1, -g},
                     {g, 0, -1},
                     {g, 0, 1},
                     {-g, 0, -1},
                     {-g, 0, 1}},
                    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
    for (Vec3d& v : p.points) {
        v = normalize(v);
    }
    return p;
}

/// Each triangle becomes four, with new points on the sphere.
Polyhedron split(const Polyhedron& p) {
    Polyhedron result = {p.points, {}};
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
        const auto [it, isNew] = middles.try_emplace(std::minmax(a, b), int(result.points.size()));
        if (isNew) {
            result.points.push_back(normalize(p.points[std::size_t(a)] + p.points[std::size_t(b)]));
        }
        return it->second;
    };
    for (const Vec3i& t : p.triangles) {
        const int a = middle(t.x, t.y), b = middle(t.y, t.z), c = middle(t.z, t.x);
        result.triangles.insert(result.triangles.end(), {{t.x, a, c}, {a, t.y, b}, {c, b, t.z}, {a, b, c}});
    }
    return result;
}

std::size_t trianglesOf(int detail) {
    return detail == coarsest ? 8 : detail < 0 ? 20 : std::size_t(20) << (2 * detail);
}

Polyhedron polyhedronOf(int detail) {
    Polyhedron p = detail == coarsest ? octahedron() : icosahedron();
    for (int i = 0; i < detail; ++i) {
        p = split(p);
    }
    return p;
}

/// By how much it has to be larger to have the unit sphere's area.
double scaleToSphere(const Polyhedron& p) {
    double area = 0;
    for (const Vec3i& t : p.triangles) {
        const Vec3d &a = p.points[std::size_t(t.x)], &b = p.points[std::size_t(t.y)], &c = p.points[std::size_t(t.z)];
        area += length(cross(b - a, c - a)) / 2;
    }
    return std::sqrt(4 * M_PI / area);
}

bool usable(const Vec3f& v) {
    return std::abs(v.x) < largestCoordinate && std::abs(v.y) < largestCoordinate && std::abs(v.z) < largestCoordinate;
}

template<class T>
bool fits(const std::vector<T>& values, std::size_t points) {
    return values.size() <= 1 || values.size() == points;
}

} // namespace

std::string PointRepairs::summary() const {
    std::string text;
    const auto say = [&text](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
    const auto sayCount = [&say](int count, const char* what) {
        if (count > 0) {
            say(std::to_string(count) + (count == 1 ? " point " : " points ") + "left out (" + what + ")");
        }
    };
    sayCount(badPoints, "not finite");
    sayCount(withoutWidth, "no width");
    if (droppedWidths) {
        say("widths ignored (wrong count)");
    }
    if (droppedColors) {
        say("displayColor ignored (wrong count)");
    }
    if (nonFiniteColors > 0) {
        say(std::to_string(nonFiniteColors) + " colors that are not finite set to zero");
    }
    if (everyNth > 1) {
        say("too many points, only one in " + std::to_string(everyNth) + " is drawn");
    } else if (coarser) {
        say("many points, drawn with less detail");
    }
    return text;
}

ControlMesh tessellate(const PointSet& set, int level, std::size_t maxTriangles, PointRepairs& repairs) {
    repairs.droppedWidths = !fits(set.widths, set.points.size());
    repairs.droppedColors = !fits(set.colors, set.points.size());
    const bool hasWidths = !set.widths.empty() && !repairs.droppedWidths;
    const bool hasColors = !set.colors.empty() && !repairs.droppedColors;
    const auto of = [](const auto& values, std::size_t i) { return values[values.size() == 1 ? 0 : i]; };

    std::vector<char> hidden(set.points.size(), 0);
    for (int i : set.hidden) {
        if (i >= 0 && std::size_t(i) < hidden.size()) {
            hidden[std::size_t(i)] = 1;
        }
    }
    std::vector<std::size_t> drawn;
    for (std::size_t i = 0; i < set.points.size(); ++i) {
        if (hidden[i]) {
            continue;
        }
        const float width = hasWidths ? of(set.widths, i) : 1.0f;
        if (!usable(set.points[i])) {
            ++repairs.badPoints;
        } else if (!(width > 0 && width < largestCoordinate)) {
            ++repairs.withoutWidth;
        } else {
            drawn.push_back(i);
        }
    }

    int detail = std::min(std::clamp(level, 0, 3) + 1, finest);
    while (detail > coarsest && drawn.size() * trianglesOf(detail) > maxTriangles) {
        --detail;
        repairs.coarser = true;
    }
    const std::size_t most = std::max<std::size_t>(maxTriangles / trianglesOf(detail), 1);
    const std::size_t step = std::max<std::size_t>((drawn.size() + most - 1) / most, 1);
    repairs.everyNth = int(step);

    const Polyhedron sphere = polyhedronOf(detail);
    const double scale = scaleToSphere(sphere);
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    mesh.normalInterpolation = mesh.colorInterpolation = ControlMesh::Interpolation::Vertex;
    const std::size_t spheres = (drawn.size() + step - 1) / step;
    mesh.points.reserve(spheres * sphere.points.size());
    mesh.normals.reserve(spheres * sphere.points.size());
    mesh.faceVertexIndices.reserve(spheres * sphere.triangles.size() * 3);
    for (std::size_t d = 0; d < drawn.size(); d += step) {
        const std::size_t i = drawn[d];
        const int base = int(mesh.points.size());
        const double radius = scale * 0.5 * double(hasWidths ? of(set.widths, i) : 1.0f);
        for (const Vec3d& v : sphere.points) {
            mesh.points.push_back(Vec3f(Vec3d(set.points[i]) + v * radius));
            mesh.normals.push_back(Vec3f(v));
        }
        if (hasColors) {
            const Rgb color = of(set.colors, i);
            repairs.nonFiniteColors += !isFinite(color);
            mesh.colors.insert(mesh.colors.end(), sphere.points.size(), isFinite(color) ? color : Rgb());
        }
        for (const Vec3i& t : sphere.triangles) {
            mesh.faceVertexIndices.insert(mesh.faceVertexIndices.end(), {base + t.x, base + t.y, base + t.z});
        }
    }
    mesh.faceVertexCounts.assign(spheres * sphere.triangles.size(), 3);
    return mesh;
}

} // namespace stf
