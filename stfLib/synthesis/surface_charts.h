// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/surface/surface_graph.h"

#include <cstdint>
#include <vector>

namespace stf {

/// The step along each link of a surface graph, in the frame (direction, left of it) of its vertices' field, mm of the
/// tile; stepMm[k] belongs to graph.neighbour[k] and is the opposite of the step back. Its length is that of the edge.
struct SurfaceSteps {
    std::vector<Vec2f> stepMm;
    std::vector<float> turn; ///< by how much the field turns along the link against parallel transport, radians
    /// The step that the coordinates shall make: stepMm, stretched so that steps around a triangle add up to less.
    std::vector<Vec2f> wantedMm;
};
SurfaceSteps surfaceSteps(const SurfaceGraph& graph, const std::vector<Vec3f>& directions, double mmPerUnit);

/// Fills `wantedMm`: a field of unit steps is no gradient where it turns; times the exponential of a potential it is
/// (the conformal factor: its gradient is the turning of the field, rotated by a right angle). The potential is solved
/// for by least squares, drawn to 0 over `rangeMm` and kept within `largest` (a factor above 1) and its inverse, so
/// that the sample's scale stays near 1 and patches fit together over wide areas. Returns the factor per vertex.
std::vector<float> scaleSteps(const SurfaceGraph& graph, double rangeMm, double largest, double mmPerUnit,
                              SurfaceSteps& steps, Progress& progress);

struct ChartOptions {
    double spacingMm = 1; ///< distance between the middles of neighbouring charts
    double reach = 1.3;   ///< radius of a chart over the spacing: how far charts overlap
    std::uint64_t seed = 0;
};

/// A cover of the surface by overlapping charts: discs with coordinates in tile millimetres that are continuous within
/// the chart, follow the direction field and hardly stretch. Every vertex is in at least one.
struct ChartCover {
    struct Chart {
        int seed;       ///< vertex at its middle, of coordinate (0, 0)
        float radiusMm; ///< geodesic
        bool rigid;     ///< keeps the seed's direction instead of following the field, as around singularities
        int first;      ///< its members: member[first] to member[first + count - 1]
        int count;
    };
    std::vector<Chart> charts;
    std::vector<int> member; ///< vertices, per chart
    std::vector<int> entryOfMember;

    // Per vertex the charts that hold it: entries first[v] to first[v + 1] - 1.
    std::vector<int> first;
    std::vector<int> chart;        ///< per entry
    std::vector<Vec2f> coord;      ///< mm
    std::vector<float> remoteness; ///< geodesic distance from the seed over the radius, 0 to 1
    std::vector<float> strain;     ///< sum of the squared logarithms of both stretches

    /// The entry of chart `c` at vertex v, or -1.
    int entryAt(int v, int c) const {
        for (int e = first[std::size_t(v)]; e < first[std::size_t(v) + 1]; ++e) {
            if (chart[std::size_t(e)] == c) {
                return e;
            }
        }
        return -1;
    }
};

/// Seeds are a Poisson-disk set; each chart grows as a discrete exponential map (Schmidt, Grimm & Wyvill 2006,
/// "Interactive decal compositing with discrete exponential maps") whose frames turn with the field, and is then
/// relaxed to least squares. What no chart holds without stretching it gets smaller charts, down to single vertices.
ChartCover coverByCharts(const SurfaceGraph& graph, const SurfaceSteps& steps, const std::vector<char>& singular,
                         const ChartOptions& options, Progress& progress);

} // namespace stf
