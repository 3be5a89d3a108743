// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/control_mesh.h"

#include <array>
#include <cmath>
#include <map>
#include <tuple>

namespace stf::test {

/// Calls f with the corners of every triangle of a fan over each face.
template<class F>
void forTriangles(const ControlMesh& mesh, const F& f) {
    std::size_t begin = 0;
    for (int count : mesh.faceVertexCounts) {
        const auto at = [&](int k) { return std::size_t(mesh.faceVertexIndices[begin + std::size_t(k)]); };
        for (int k = 2; k < count; ++k) {
            f(at(0), at(k - 1), at(k));
        }
        begin += std::size_t(count);
    }
}

inline std::size_t trianglesOf(const ControlMesh& mesh) {
    std::size_t count = 0;
    forTriangles(mesh, [&](std::size_t, std::size_t, std::size_t) { ++count; });
    return count;
}

inline double areaOf(const ControlMesh& mesh) {
    double area = 0;
    forTriangles(mesh, [&](std::size_t a, std::size_t b, std::size_t c) {
        const Vec3d p(mesh.points[a]);
        area += length(cross(Vec3d(mesh.points[b]) - p, Vec3d(mesh.points[c]) - p)) / 2;
    });
    return area;
}

/// By Gauss's theorem; positive where faces are counter-clockwise seen from outside.
inline double volumeOf(const ControlMesh& mesh) {
    double volume = 0;
    forTriangles(mesh, [&](std::size_t a, std::size_t b, std::size_t c) {
        volume += dot(Vec3d(mesh.points[a]), cross(Vec3d(mesh.points[b]), Vec3d(mesh.points[c]))) / 6;
    });
    return volume;
}

/// The same mesh with one point per place.
inline ControlMesh weldedByPlace(ControlMesh mesh) {
    std::map<std::tuple<float, float, float>, int> places;
    for (int& v : mesh.faceVertexIndices) {
        const Vec3f& p = mesh.points[std::size_t(v)];
        v = places.try_emplace({p.x, p.y, p.z}, v).first->second;
    }
    return mesh;
}

using EdgeUses = std::map<std::pair<int, int>, int>;

/// How often each edge is used forth less how often back.
inline EdgeUses edgesOf(const ControlMesh& mesh) {
    EdgeUses uses;
    std::size_t begin = 0;
    for (int count : mesh.faceVertexCounts) {
        for (int k = 0; k < count; ++k) {
            const int a = mesh.faceVertexIndices[begin + std::size_t(k)];
            const int b = mesh.faceVertexIndices[begin + std::size_t((k + 1) % count)];
            uses[std::minmax(a, b)] += a < b ? 1 : -1;
        }
        begin += std::size_t(count);
    }
    return uses;
}

inline std::size_t openEdgesOf(const ControlMesh& mesh) {
    std::size_t open = 0;
    for (const auto& [edge, uses] : edgesOf(mesh)) {
        open += uses != 0;
    }
    return open;
}

/// Points less edges plus faces; every point is in use.
inline int eulerOf(const ControlMesh& mesh) {
    return int(mesh.points.size()) - int(edgesOf(mesh).size()) + int(mesh.faceVertexCounts.size());
}

inline double longestEdgeOf(const ControlMesh& mesh) {
    double longest = 0;
    for (const auto& [edge, uses] : edgesOf(mesh)) {
        longest = std::max(
            longest, double(length(mesh.points[std::size_t(edge.first)] - mesh.points[std::size_t(edge.second)])));
    }
    return longest;
}

inline Box3f extentOf(const ControlMesh& mesh) {
    Box3f box;
    for (const Vec3f& p : mesh.points) {
        box.add(p);
    }
    return box;
}

} // namespace stf::test
