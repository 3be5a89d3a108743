// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/curvature.h"

#include "stfLib/base/parallel.h"

#include <Eigen/Dense>

namespace stf {

namespace {

Curvature curvatureAt(const SurfaceGraph& g, std::size_t v) {
    Vec3d x, y;
    const Vec3d n(g.normals[v]);
    orthonormalBasis(n, x, y);
    // dn = [a b; b c] e for every edge e, in the tangent plane.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int k = g.first[v]; k < g.first[v + 1]; ++k) {
        const std::size_t u = std::size_t(g.neighbour[std::size_t(k)]);
        const Vec3d e = Vec3d(g.points[u]) - Vec3d(g.points[v]), dn = Vec3d(g.normals[u]) - n;
        const double ex = dot(e, x), ey = dot(e, y), weight = 1 / std::max(1e-300, dot(e, e));
        const Eigen::Vector3d rows[2] = {{ex, ey, 0}, {0, ex, ey}};
        const double values[2] = {dot(dn, x), dot(dn, y)};
        for (int r = 0; r < 2; ++r) {
            normal += weight * rows[r] * rows[r].transpose();
            right += weight * rows[r] * values[r];
        }
    }
    Curvature out;
    out.direction1 = Vec3f(x);
    // Relative to the weights, which make the matrix free of units.
    normal += 1e-9 * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d s = normal.ldlt().solve(right);
    Eigen::Matrix2d shape;
    shape << s[0], s[1], s[1], s[2];
    if (!shape.allFinite()) {
        return out;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(shape);
    out.k1 = float(eigen.eigenvalues()[1]);
    out.k2 = float(eigen.eigenvalues()[0]);
    out.direction1 = Vec3f(normalize(x * eigen.eigenvectors()(0, 1) + y * eigen.eigenvectors()(1, 1)));
    return out;
}

} // namespace

std::vector<Curvature> curvatures(const SurfaceGraph& graph) {
    std::vector<Curvature> out(graph.size());
    parallelFor(graph.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            out[v] = curvatureAt(graph, v);
        }
    });
    return out;
}

} // namespace stf
