// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/surface/control_mesh.h"

namespace stf {

/// A triangulated limit surface. Vertices are shared where the surface is smooth; texture coordinates have their own
/// vertices, so that a chart may end along an edge.
struct RefinedSurface {
    std::vector<Vec3f> points;      ///< limit positions, object space
    std::vector<Vec3f> normals;     ///< unit limit normals, outward (left-handed meshes already turned)
    std::vector<Vec3i> triangles;   ///< counter-clockwise seen from outside
    std::vector<int> triangleFace;  ///< face of the control mesh (its number before `sanitize`'s drops is not kept)
    std::vector<Vec2f> uvs;         ///< empty without uv
    std::vector<Vec3i> uvTriangles; ///< one per triangle, indices into uvs
    std::vector<Rgb> colors;        ///< one per point, empty: grey
    std::vector<Vec3f> orientation; ///< one per point: wanted tangent, unit or zero (no wish); empty: none anywhere
    /// Shading normals per triangle corner (3 per triangle) where the mesh is faceted or has authored face-varying
    /// normals; empty: use `normals`.
    std::vector<Vec3f> cornerNormals;
    /// Shading normals by `triangleFace`, where nobody asked for normals of points and facets are all there is: then
    /// `normals` and `cornerNormals` are empty.
    std::vector<Vec3f> faceNormals;
    Box3f bounds;
};

/// A surface in another pose: what differs from the RefinedSurface whose points ride along.
struct SurfacePose {
    std::vector<Vec3f> points;        ///< one per point of the surface
    std::vector<Vec3f> normals;       ///< unit, one per point
    std::vector<Vec3f> cornerNormals; ///< 3 per triangle; empty: use `normals`
};

/// The surface with the points and normals of a pose.
RefinedSurface inPose(const RefinedSurface& surface, SurfacePose pose);

struct RefineOptions {
    /// Refine until the longest edge of a typical face (95th percentile) is below this, in object units; 0: only
    /// `level`.
    float targetEdge = 0;
    /// Uniform levels at least (Hydra's refine level) and at most.
    int level = 0;
    int maxLevel = 6;
    /// Never more triangles than this; the level is lowered and a message says so.
    std::size_t maxTriangles = 2'000'000;
    /// The same for levels that only `targetEdge` asks for, without a word; levels up to `level` are made all the same.
    std::size_t maxEdgeTriangles = 2'000'000;
    /// Whether each point needs a normal (shells do); a faceted mesh can do without.
    bool pointNormals = true;
};

/// Refines a sanitized mesh by OpenSubdiv (uniform levels, then vertices are moved to the limit surface; limit normals
/// from limit tangents). Scheme None is triangulated only, but with `targetEdge` set its triangles are split evenly so
/// that shells have samples. Deterministic. Throws Error with a reason.
RefinedSurface refine(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages);

/// The same in the rest pose of a mesh that has one: level and triangulation are chosen there, so that they do not
/// depend on the pose. The mesh's points ride along: `pose` becomes their limit surface.
RefinedSurface refineAtRest(const ControlMesh& mesh, const RefineOptions& options, const MessageSink& messages,
                            SurfacePose& pose);

} // namespace stf
