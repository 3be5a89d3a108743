// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/base/vec.h"

#include <string>
#include <vector>

namespace stf {

/// A polygon or subdivision mesh as a host hands it in. Plain values, one owner, no threads.
struct ControlMesh {
    enum class Scheme { None, CatmullClark, Loop, Bilinear };
    enum class Interpolation { Constant, Uniform, Vertex, FaceVarying };

    std::vector<int> faceVertexCounts;
    std::vector<int> faceVertexIndices;
    std::vector<int> holeIndices;
    std::vector<Vec3f> points;
    Scheme scheme = Scheme::CatmullClark;
    bool leftHanded = false;

    // Subdivision tags, with the meaning they have in UsdGeomMesh.
    std::vector<int> cornerIndices;
    std::vector<float> cornerSharpnesses;
    std::vector<int> creaseIndices;
    std::vector<int> creaseLengths;
    std::vector<float> creaseSharpnesses; ///< one per crease or one per crease edge
    std::string interpolateBoundary = "edgeAndCorner";
    std::string faceVaryingInterpolation = "cornersPlus1";

    /// Texture coordinates: `uvIndices` has one entry per face vertex; empty where there is no uv.
    std::vector<Vec2f> uvs;
    std::vector<int> uvIndices;

    /// Authored normals, used for scheme None only (a subdivided surface has its own).
    std::vector<Vec3f> normals;
    Interpolation normalInterpolation = Interpolation::Vertex;

    /// displayColor; empty: grey.
    std::vector<Rgb> colors;
    Interpolation colorInterpolation = Interpolation::Constant;

    /// Which part each face belongs to, from 0; parts may have materials of their own. Empty: there is one part.
    std::vector<int> faceParts;

    /// Where the points are in the rest pose, one per point; empty: the mesh has none.
    std::vector<Vec3f> rest;

    /// Tangents that the sample's x axis shall follow; zero: no wish there. Empty: none anywhere.
    std::vector<Vec3f> orientation;
    Interpolation orientationInterpolation = Interpolation::Vertex;
};

/// What `sanitize` found and mended.
struct MeshRepairs {
    int droppedFaces = 0;    ///< fewer than 3 distinct vertices, or indices out of range
    int mendedFaces = 0;     ///< repeated neighbouring vertices were merged
    int nonFinitePoints = 0; ///< faces that use them are dropped; the points themselves become zero
    bool droppedUvs = false; ///< wrong counts or indices
    int nonFiniteUvs = 0;    ///< set to zero
    bool droppedColors = false;
    bool droppedNormals = false;
    bool droppedTags = false; ///< creases, corners, holes out of range
    bool droppedRest = false; ///< wrong count, not finite, or all points in one
    bool droppedOrientation = false;
    int nonFiniteOrientations = 0; ///< set to zero: no wish there
    /// One sentence, empty if nothing had to be mended.
    std::string summary() const;
};

/// Makes a mesh safe for everything below: drops what is degenerate, out of range or not finite (coordinates beyond
/// 1e18 count as not finite, since their squares overflow). Points keep their numbers, faces do not. Afterwards the
/// counts and indices fit, arrays per face or face vertex follow the remaining faces, and tags name existing vertices.
/// Throws Error if no face is left ("has no usable face").
MeshRepairs sanitize(ControlMesh& mesh);

} // namespace stf
