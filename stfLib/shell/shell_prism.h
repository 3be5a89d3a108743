// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/shell/shell_surface.h"

namespace stf {

/// A triangle of the surface, extruded along directions that are linear over it:
/// X(b1, b2, d) = P0 + b1 e1 + b2 e2 - d (n0 + b1 m1 + b2 m2), with the depth d in object units. For a fixed d that is
/// a triangle again, so the prism lies in the hull of its six corners. Neighbours share their side faces exactly.
struct ShellPrism {
    Vec3d p0, e1, e2;
    Vec3d n0, m1, m2;        ///< outward direction at the first corner and its change to the others
    double t0, t1, t2;       ///< thickness at the first corner and its change
    Vec3d facet;             ///< unit normal of the triangle
    double facetLo, facetHi; ///< bounds of (direction . facet) over the triangle; lo <= 0: no slab test is possible

    /// False for triangles without area or with non-finite data, which own no space.
    bool set(const RefinedSurface& surface, const ShellBoundary& boundary, std::size_t triangle);

    double thickness(double b1, double b2) const { return t0 + t1 * b1 + t2 * b2; }
    double largestThickness() const { return std::max(t0, std::max(t0 + t1, t0 + t2)); }
    Vec3d direction(double b1, double b2) const { return n0 + m1 * b1 + m2 * b2; }
    /// Corner c of the triangle at depth d.
    Vec3d corner(int c, double d) const {
        return c == 0 ? p0 - n0 * d : c == 1 ? p0 + e1 - (n0 + m1) * d : p0 + e2 - (n0 + m2) * d;
    }

    struct Point {
        double b1 = 0, b2 = 0, d = 0;
        bool folded = false; ///< inside out: the offset has passed its focus
    };
    Vec3d at(const Point& p) const { return p0 + e1 * p.b1 + e2 * p.b2 - direction(p.b1, p.b2) * p.d; }
    /// Derivative of X by b1, b2 or d.
    Vec3d column(int i, const Point& p) const {
        return i == 0 ? e1 - m1 * p.d : i == 1 ? e2 - m2 * p.d : -direction(p.b1, p.b2);
    }
    /// One step of Newton's method from `point` towards the point p0 + w; `step` is what was added to b1, b2 and d.
    /// False where the derivative is singular.
    bool newton(const Vec3d& w, Point& point, Vec3d& step) const;

    /// Inverts X for the point p0 + w by Newton's method. False if the point is not between `outside` above the surface
    /// and `beyond` below the inner boundary, or not over the triangle.
    bool invert(const Vec3d& w, double outside, double beyond, Point& point) const;

    /// The covector g with g . X_b1 = s1, g . X_b2 = s2 and g . X_d = 0 at a point: the gradient of a quantity that is
    /// linear over the triangle and constant along depth. False where the prism is degenerate.
    bool gradient(const Point& point, double s1, double s2, Vec3d& g) const;
};

} // namespace stf
