// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the surface layer: what subdivision and polygon refinement share.

#include "stfLib/base/triangulate_face.h"
#include "stfLib/surface/refined_surface.h"

namespace stf {

/// `pose`, where not null, holds one point per control point and becomes the pose of the refined surface.
RefinedSurface refineSubdivision(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages,
                                 SurfacePose* pose);
RefinedSurface refinePolygons(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages,
                              SurfacePose* pose);

/// Sum of the triangles' normals at each point, weighted by the angle there, so that it does not depend on the
/// triangulation of planar faces. `cornerNormals` (3 per triangle), where not empty, replace the triangles' own. Unit,
/// or zero where nothing is known.
std::vector<Vec3f> angleWeightedNormals(const std::vector<Vec3f>& points, const std::vector<Vec3i>& triangles,
                                        const std::vector<Vec3f>& cornerNormals = {});

/// Angle at corner `c` of a triangle, radians.
float cornerAngle(const std::vector<Vec3f>& points, const Vec3i& triangle, int c);

/// One value per control point; values of faces and face vertices are averaged there. Empty: there are none.
std::vector<Vec3f> controlPointValues(const ControlMesh& mesh, const std::vector<Vec3f>& values,
                                      ControlMesh::Interpolation interpolation);

/// Interpolated tangents as unit vectors; zero where those around contradict one another or have no wish.
void normalizeOrientation(std::vector<Vec3f>& orientation);

/// The 95th percentile of lengths; reorders them.
double typicalLargest(std::vector<double>& lengths);

/// Texture coordinates get a vertex of their own per (point, value) pair: values equal at a point are merged, so that
/// unindexed face-varying data does not cut the surface along every edge.
void weldUvs(const ControlMesh& mesh, std::vector<Vec2f>& uvs, std::vector<int>& uvIndices);

} // namespace stf
