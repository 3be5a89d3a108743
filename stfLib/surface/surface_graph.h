// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/refined_surface.h"

#include <vector>

namespace stf {

/// A triangulated surface as a graph: a vertex per position (points that modellers doubled along a cut are one), with
/// its neighbours. Immutable once made. Non-manifold edges, open boundaries and lone vertices are allowed.
struct SurfaceGraph {
    std::vector<Vec3f> points;      ///< object space
    std::vector<Vec3f> normals;     ///< unit, outward
    std::vector<Vec3i> triangles;   ///< of the surface, in its order, in vertices of the graph
    std::vector<int> vertexOfPoint; ///< per point of the surface
    std::vector<float> area;        ///< a third of the triangles around a vertex, object units squared
    std::vector<int> first;         ///< neighbours of v: neighbour[first[v]] to neighbour[first[v + 1] - 1], ascending
    std::vector<int> neighbour;

    std::size_t size() const { return points.size(); }
    double totalArea() const;
};

SurfaceGraph surfaceGraph(const RefinedSurface& surface);

/// The link from u to v, or -1.
int linkOf(const SurfaceGraph& graph, int u, int v);

/// Weight of each link for the surface's Laplacian: half the cotangents of the angles opposite (Pinkall & Polthier
/// 1993), those of slivers bounded, not below a twentieth: obtuse triangles must not make energies indefinite.
std::vector<float> cotangentWeights(const SurfaceGraph& graph);

} // namespace stf
