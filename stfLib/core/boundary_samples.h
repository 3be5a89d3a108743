// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <cstdint>
#include <vector>

namespace stf {

/// A place on a triangle: (1 - b1 - b2) a + b1 b + b2 c of its corners.
struct TrianglePlace {
    std::uint32_t triangle = 0;
    float b1 = 0, b2 = 0;
};

inline Vec3f pointAt(const std::vector<Vec3f>& points, const Vec3i& t, const TrianglePlace& p) {
    return points[std::size_t(t.x)] * (1 - p.b1 - p.b2) + points[std::size_t(t.y)] * p.b1 +
           points[std::size_t(t.z)] * p.b2;
}

/// Samples of a surface at least a distance apart, each with the part of the surface that is nearest to it: a set of
/// places spread evenly over that part. They are named by triangles, so that they ride along when the points move.
struct BoundarySamples {
    std::vector<TrianglePlace> places;
    std::vector<TrianglePlace> parts;     ///< of all samples, one after the other
    std::vector<std::uint32_t> firstPart; ///< sample i: parts [firstPart[i], firstPart[i + 1])
    std::vector<double> triangleAreas;    ///< where they were spread: all parts of a triangle share its area

    std::size_t count() const { return places.size(); }
    /// Area of each sample's part in the pose of `points`; together exactly that of the triangles that have parts,
    /// scaled to the whole surface.
    std::vector<float> areas(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles) const;
};

/// About `wanted` samples (within a tenth), well spread: a Poisson-disk set by darts (Cook 1986), radii chosen so that
/// darts hardly find room any more. Sides of a thin sheet do not see each other. Deterministic by `seed`. None where
/// the surface has no area.
BoundarySamples spreadSamples(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles, std::size_t wanted,
                              std::uint64_t seed);

double surfaceArea(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles);

} // namespace stf
