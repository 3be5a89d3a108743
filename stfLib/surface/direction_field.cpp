// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/direction_field.h"

#include "stfLib/base/parallel.h"
#include "stfLib/surface/connection_energy.h"

#include <algorithm>
#include <complex>

namespace stf {

namespace {

using Complex = std::complex<double>;
constexpr double kPi = 3.14159265358979323846;
constexpr double guideWeight = 50; ///< of an authored vector, in units of a vertex's own weight

/// The unit vector of v's tangent plane that has the angle 0, and its left.
void frameOf(const SurfaceGraph& g, std::size_t v, Vec3d& x, Vec3d& y) {
    orthonormalBasis(Vec3d(g.normals[v]), x, y);
}

/// Rotation from angles at i to angles at j.
Complex transport(const SurfaceGraph& g, std::size_t i, std::size_t j) {
    Vec3d xi, yi, xj, yj;
    frameOf(g, i, xi, yi);
    frameOf(g, j, xj, yj);
    const Vec3d d = carryTangent(xi, Vec3d(g.normals[i]), Vec3d(g.normals[j]));
    const Complex r(dot(d, xj), dot(d, yj));
    const double l = std::abs(r);
    return l > 0 ? r / l : Complex(1, 0);
}

ConnectionEnergy energyOf(const SurfaceGraph& g, const std::vector<Vec3f>& guide) {
    ConnectionEnergy l;
    l.first = g.first;
    l.neighbour = g.neighbour;
    l.link.assign(g.neighbour.size(), {});
    l.diagonal.assign(g.size(), 0);
    l.mass.resize(g.size());
    const std::vector<float> weight = cotangentWeights(g);
    parallelFor(g.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            for (int k = g.first[i]; k < g.first[i + 1]; ++k) {
                const double w = double(weight[std::size_t(k)]);
                l.link[std::size_t(k)] =
                    std::complex<float>(w * transport(g, std::size_t(g.neighbour[std::size_t(k)]), i));
                l.diagonal[i] += w;
            }
            l.mass[i] = std::max(1e-300, double(g.area[i]));
        }
    });
    if (!guide.empty()) {
        l.wanted.assign(g.size(), 0.0);
        for (std::size_t i = 0; i < g.size(); ++i) {
            Vec3d x, y;
            frameOf(g, i, x, y);
            const Vec3d d(guide[i]);
            const Complex z(dot(d, x), dot(d, y));
            if (std::abs(z) > 0 && std::isfinite(std::abs(z))) {
                l.wanted[i] = z / std::abs(z) * guideWeight;
                l.diagonal[i] += guideWeight;
            }
        }
    }
    return l;
}

} // namespace

Vec3d carryTangent(const Vec3d& direction, const Vec3d& from, const Vec3d& to) {
    // Rodrigues' rotation about from x to, written without the angle.
    const double c = dot(from, to);
    if (c < -0.999999) {
        return -direction;
    }
    const Vec3d axis = cross(from, to);
    return direction * c + cross(axis, direction) + axis * (dot(axis, direction) / (1 + c));
}

std::vector<Vec3f> smoothDirections(const SurfaceGraph& graph, const std::vector<Vec3f>& guide, Progress& progress) {
    if (!guide.empty() && guide.size() != graph.size()) {
        throw Error("the tangent field does not have one vector per vertex");
    }
    const std::vector<Complex> z = minimize(energyOf(graph, guide), "direction field", progress);
    std::vector<Vec3f> directions(graph.size());
    for (std::size_t i = 0; i < graph.size(); ++i) {
        Vec3d x, y;
        frameOf(graph, i, x, y);
        const double l = std::abs(z[i]);
        const Complex u = l > 0 && std::isfinite(l) ? z[i] / l : Complex(1, 0);
        directions[i] = Vec3f(x * u.real() + y * u.imag());
    }
    return directions;
}

std::vector<Singularity> singularities(const SurfaceGraph& graph, const std::vector<Vec3f>& directions) {
    std::vector<Singularity> found;
    const auto angle = [&](std::size_t v) {
        Vec3d x, y;
        frameOf(graph, v, x, y);
        const Vec3d d(directions[v]);
        return Complex(dot(d, x), dot(d, y));
    };
    for (std::size_t t = 0; t < graph.triangles.size(); ++t) {
        const Vec3i& tri = graph.triangles[t];
        double turn = 0;
        Complex around(1, 0);
        for (int c = 0; c < 3; ++c) {
            const std::size_t i = std::size_t(tri[c]), j = std::size_t(tri[(c + 1) % 3]);
            // From the lower to the higher vertex: both triangles of an edge see the same number.
            const Complex r = i < j ? transport(graph, i, j) : std::conj(transport(graph, j, i));
            const double w =
                i < j ? std::arg(angle(j) / (r * angle(i))) : -std::arg(angle(i) / (std::conj(r) * angle(j)));
            turn += w;
            around *= r;
        }
        // What the turns leave over is the curvature that the triangle holds.
        const int index = int(std::lround((turn + std::arg(around)) / (2 * kPi)));
        if (index != 0) {
            found.push_back({int(t), index});
        }
    }
    return found;
}

std::vector<char> singularVertices(const SurfaceGraph& graph, const std::vector<Singularity>& list) {
    std::vector<char> singular(graph.size(), 0);
    for (const Singularity& p : list) {
        for (int c = 0; c < 3; ++c) {
            singular[std::size_t(graph.triangles[std::size_t(p.triangle)][c])] = 1;
        }
    }
    return singular;
}

} // namespace stf
