// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/transform.h"

#include <vector>

namespace stf {

/// A triangle mesh as a reader or a shape makes it: mm, counter-clockwise seen from outside where it is oriented.
struct TriangleMesh {
    std::vector<Vec3d> points;
    std::vector<Vec3i> triangles;

    const Vec3d& corner(std::size_t triangle, int k) const { return points[std::size_t(triangles[triangle][k])]; }
};

/// Axis-aligned box in double precision; empty until something was added.
struct Box3d {
    Vec3d lo{1e300}, hi{-1e300};
    void add(const Vec3d& p);
    bool empty() const { return lo.x > hi.x; }
    Vec3d size() const { return empty() ? Vec3d(0.0) : hi - lo; }
    Vec3d middle() const { return (lo + hi) * 0.5; }
    /// From p to the nearest point of the box; 0 inside.
    double distance(const Vec3d& p) const { return std::sqrt(squaredDistance(p)); }
    double squaredDistance(const Vec3d& p) const {
        double squares = 0;
        for (int k = 0; k < 3; ++k) {
            const double d = std::max(std::max(lo[k] - p[k], 0.0), p[k] - hi[k]);
            squares += d * d;
        }
        return squares;
    }
};

Box3d boundsOf(const TriangleMesh& mesh);

/// Volume a closed mesh encloses, in mm^3, by the divergence theorem; negative where its triangles face inward. Taken
/// about the middle of its bounds, so that a mesh far from the origin keeps its digits.
double signedVolume(const TriangleMesh& mesh);

/// The mesh under an affine map; a map that mirrors turns the triangles, so that outward stays outward.
TriangleMesh transformed(const TriangleMesh& mesh, const Transform& transform);

/// Adds a polygon, given by its points in order, as triangles that lie within it where it is flat, concave or not. A
/// fan where a point is not there yet.
void addPolygon(TriangleMesh& mesh, const std::vector<int>& corners);

/// Adds the triangles of `more` to `mesh`.
void append(TriangleMesh& mesh, const TriangleMesh& more);

} // namespace stf
