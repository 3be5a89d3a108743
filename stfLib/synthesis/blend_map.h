// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/synthesis/exemplar_map.h"
#include "stfLib/synthesis/surface_charts.h"

#include <array>
#include <cstdint>

namespace stf {

/// Up to three places of the sample that a triangle shows at once, as functions of the first one's coordinate: the
/// others are other[i] + (c - base) through `across[i]`, weights are weight[k] + dot(slope[k], c - base).
struct TriangleBlend {
    Vec2f base; ///< coordinate of the first place at the triangle's first corner, mm
    std::array<Vec2f, 2> other{};
    std::array<std::array<Vec2f, 2>, 2> across{}; ///< [place][x, y of the first place]: mm per mm
    std::array<float, 3> weight{1, 0, 0};
    std::array<Vec2f, 3> slope{}; ///< per mm
};

/// A surface that shows overlapping places of a sample, each at its random part, with weights that are continuous over
/// the surface and vanish where a place ends. To be blended by transport/histogram_blend.
struct BlendMap {
    ExemplarMap first; ///< the place of the largest weight of each triangle
    std::vector<TriangleBlend> triangles;
};

/// Charts are those of synthesis (surface_charts), which take the part of the triangular lattice of Heitz & Neyret 2018
/// on surfaces that have none: around each vertex count the three that are most central. Throws Error, Cancelled.
BlendMap blendMap(const RefinedSurface& surface, const Vec2d& tileMm, double mmPerUnit, std::uint64_t seed,
                  Progress& progress);

/// The blend at a coordinate of the first place (mm, any representative modulo the tile) on or beside a triangle:
/// weights are positive and add up to 1.
struct PlacesAt {
    std::array<Vec2f, 2> other; ///< mm
    std::array<float, 3> weight;
};
PlacesAt placesAt(const TriangleBlend& triangle, const Vec2f& coordMm, const Vec2f& tileMm);

} // namespace stf
