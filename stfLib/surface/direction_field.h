// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/surface/surface_graph.h"

#include <vector>

namespace stf {

/// A smooth field of unit tangents, one per vertex: the smallest eigenvector of the connection Laplacian (Knoeppel,
/// Crane, Pinkall & Schroeder 2013, "Globally Optimal Direction Fields"), whose singularities are as few and as well
/// placed as smoothness asks. Vectors are carried between tangent planes by the least rotation of the normals. Solved
/// by inverse iteration with a sparse Cholesky factor on an algebraic hierarchy of merged vertices (Galerkin, so that
/// the coarse problem is the fine one, restricted), then smoothed level by level: linear in the number of vertices.
///
/// `guide`, where not empty, has one vector per vertex that the field shall follow (zero: no wish there); what is not
/// given is filled in smoothly. Every component of the surface gets a field. Deterministic for any number of threads.
std::vector<Vec3f> smoothDirections(const SurfaceGraph& graph, const std::vector<Vec3f>& guide, Progress& progress);

/// Where the field turns around once and more: a triangle, and how often (index +1, -1 ...). The indices of a closed
/// surface sum up to its Euler characteristic (Poincare & Hopf).
struct Singularity {
    int triangle;
    int index;
};
std::vector<Singularity> singularities(const SurfaceGraph& graph, const std::vector<Vec3f>& directions);
/// Per vertex of the graph: 1 at the corners of singular triangles.
std::vector<char> singularVertices(const SurfaceGraph& graph, const std::vector<Singularity>& singularities);

/// The tangent `direction` of the plane with unit normal `from`, carried to that with `to` by the least rotation.
Vec3d carryTangent(const Vec3d& direction, const Vec3d& from, const Vec3d& to);

} // namespace stf
