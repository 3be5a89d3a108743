// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_prism.h"

namespace stf {

namespace {
// Points on a shared side face must be found from one of its prisms at least.
constexpr double barycentricTolerance = 1e-4;
} // namespace

bool ShellPrism::set(const RefinedSurface& surface, const ShellBoundary& boundary, std::size_t triangle) {
    const Vec3i& t = surface.triangles[triangle];
    Vec3d p[3], n[3];
    double thickness[3];
    for (int c = 0; c < 3; ++c) {
        const std::size_t i = std::size_t(t[c]);
        p[c] = Vec3d(surface.points[i]);
        thickness[c] = double(boundary.thickness[i]);
        // The direction to the inner boundary; the normal's where the shell is too thin for floats to tell.
        const Vec3d across = p[c] - Vec3d(boundary.inner[i]);
        n[c] = across / thickness[c];
        const double scale = std::max(std::abs(p[c].x), std::max(std::abs(p[c].y), std::abs(p[c].z)));
        if (!(thickness[c] > 1e-4 * scale) || !(dot(n[c], n[c]) < 9)) {
            n[c] = Vec3d(surface.normals[i]);
        }
        if (!isFinite(p[c]) || !isFinite(n[c]) || !(thickness[c] > 0) || !std::isfinite(thickness[c])) {
            return false;
        }
    }
    p0 = p[0];
    e1 = p[1] - p[0];
    e2 = p[2] - p[0];
    n0 = n[0];
    m1 = n[1] - n[0];
    m2 = n[2] - n[0];
    t0 = thickness[0];
    t1 = thickness[1] - thickness[0];
    t2 = thickness[2] - thickness[0];
    const Vec3d area = cross(e1, e2);
    if (!(dot(area, area) > 0)) {
        return false;
    }
    facet = normalize(area);
    facetLo = std::min(dot(n[0], facet), std::min(dot(n[1], facet), dot(n[2], facet)));
    facetHi = std::max(dot(n[0], facet), std::max(dot(n[1], facet), dot(n[2], facet)));
    return true;
}

bool ShellPrism::newton(const Vec3d& w, Point& point, Vec3d& step) const {
    const Vec3d n = direction(point.b1, point.b2);
    const Vec3d c1 = e1 - m1 * point.d, c2 = e2 - m2 * point.d;
    const Vec3d residual = w - (e1 * point.b1 + e2 * point.b2 - n * point.d);
    const Vec3d c1c2 = cross(c1, c2);
    const double det = -dot(c1c2, n);
    if (!(std::abs(det) > 0)) {
        return false;
    }
    step = {-dot(residual, cross(c2, n)) / det, -dot(residual, cross(n, c1)) / det, dot(residual, c1c2) / det};
    point.b1 += step.x;
    point.b2 += step.y;
    point.d += step.z;
    point.folded = det > 0;
    return true;
}

bool ShellPrism::invert(const Vec3d& w, double outside, double beyond, Point& point) const {
    Point at{1.0 / 3, 1.0 / 3, 0, false};
    const double along = dot(direction(at.b1, at.b2), facet);
    at.d = along > 0.05 ? -dot(w, facet) / along : 0;
    const double depthScale = largestThickness() + outside + beyond;
    double &b1 = at.b1, &b2 = at.b2, &d = at.d;
    bool converged = false;
    for (int step = 0; step < 20 && !converged; ++step) {
        Vec3d by;
        if (!newton(w, at, by)) {
            return false;
        }
        // The first step is nearly exact already on surfaces that are flat over a triangle.
        if (!(std::abs(b1) < 8 && std::abs(b2) < 8) || (step == 0 && (b1 < -1 || b2 < -1 || b1 + b2 > 2))) {
            return false;
        }
        converged = std::abs(by.x) < 1e-7 && std::abs(by.y) < 1e-7 && std::abs(by.z) < 1e-7 * depthScale;
    }
    if (!converged || b1 < -barycentricTolerance || b2 < -barycentricTolerance || b1 + b2 > 1 + barycentricTolerance) {
        return false;
    }
    b1 = std::clamp(b1, 0.0, 1.0);
    b2 = std::clamp(b2, 0.0, 1.0 - b1);
    if (d < -outside || d > thickness(b1, b2) + beyond) {
        return false;
    }
    point = at;
    return true;
}

bool ShellPrism::gradient(const Point& point, double s1, double s2, Vec3d& g) const {
    const Vec3d n = direction(point.b1, point.b2);
    const Vec3d c1 = e1 - m1 * point.d, c2 = e2 - m2 * point.d;
    const double det = dot(cross(c1, c2), n);
    if (!(std::abs(det) > 0)) {
        return false;
    }
    g = (cross(c2, n) * s1 + cross(n, c1) * s2) / det;
    return isFinite(g);
}

} // namespace stf
