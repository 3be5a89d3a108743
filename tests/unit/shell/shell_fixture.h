// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shells with closed-form answers, shared by the tests of the shell grid.

#include "stfLib/shell/shell_grid.h"
#include "tests/unit/surface/test_meshes.h"

#include <algorithm>
#include <random>

namespace stf::test {

struct Shell {
    RefinedSurface surface;
    ShellBoundary boundary;
    ExemplarMap map;
    ShellGrid grid;
};

inline RefinedSurface refined(ControlMesh mesh, float targetEdge = 0) {
    sanitize(mesh);
    RefineOptions options;
    options.targetEdge = targetEdge;
    return refine(mesh, options, {});
}

/// Coordinates given by a function of the surface point; gradients by two more.
template<class Coords, class GradX, class GradY>
ExemplarMap analyticMap(const RefinedSurface& s, Vec2d tile, const Coords& coords, const GradX& gradX,
                        const GradY& gradY) {
    ExemplarMap map;
    map.tileMm = tile;
    for (const Vec3i& t : s.triangles) {
        for (int c = 0; c < 3; ++c) {
            const Vec3d p(s.points[std::size_t(t[c])]);
            const Vec2d xy = coords(p);
            map.cornerCoords.push_back({float(xy.x), float(xy.y)});
            map.gradientX.push_back(Vec3f(gradX(p)));
            map.gradientY.push_back(Vec3f(gradY(p)));
        }
    }
    return map;
}

inline ShellGrid build(const RefinedSurface& s, const ShellBoundary& b, const ExemplarMap& map, double mmPerUnit = 1,
                       float voxel = 0, const MessageSink& sink = {}) {
    ShellGridOptions options;
    options.mmPerUnit = mmPerUnit;
    // An eighth of the thickness, unless told.
    options.voxelSize =
        voxel > 0 || b.thickness.empty() ? voxel : *std::max_element(b.thickness.begin(), b.thickness.end()) / 8;
    Progress progress;
    return ShellGrid::build(s, b, map, options, progress, sink);
}

inline Shell tiled(const ControlMesh& mesh, float thickness, Vec2d tile, float targetEdge = 0) {
    Shell shell;
    shell.surface = refined(mesh, targetEdge);
    shell.boundary = offsetInward(shell.surface, thickness, {});
    shell.map = tileByUv(shell.surface, tile, 1, {});
    shell.grid = build(shell.surface, shell.boundary, shell.map);
    return shell;
}

inline const Vec3d axisX(10, 0, 0), axisY(0, 7, 7);

/// On a sphere about zero: coordinates linear in the direction, so constant along depth; smooth everywhere.
inline Vec2d ballCoords(const Vec3d& p) {
    return {dot(axisX, normalize(p)), dot(axisY, normalize(p))};
}
inline Vec3d ballGradient(const Vec3d& axis, const Vec3d& p) {
    const Vec3d n = normalize(p);
    return (axis - n * dot(axis, n)) / length(p);
}

inline Shell ball(double mmPerUnit = 1, double radius = 1, Vec2d tile = {3, 4}) {
    Shell shell;
    shell.surface = refined(sphere(32, radius));
    shell.boundary = offsetInward(shell.surface, float(0.1 * radius), {});
    shell.map = analyticMap(
        shell.surface, tile, ballCoords, [](const Vec3d& p) { return ballGradient(axisX, p); },
        [](const Vec3d& p) { return ballGradient(axisY, p); });
    shell.grid = build(shell.surface, shell.boundary, shell.map, mmPerUnit);
    return shell;
}

inline double wrapped(double d, double tile) {
    return std::abs(d - tile * std::round(d / tile));
}

class Points {
public:
    explicit Points(unsigned seed) : random_(seed) {}
    double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
    Vec3d direction() {
        std::normal_distribution<double> normal;
        return normalize(Vec3d(normal(random_), normal(random_), normal(random_)));
    }

private:
    std::mt19937 random_;
};

} // namespace stf::test
