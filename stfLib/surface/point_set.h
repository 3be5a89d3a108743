// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/surface/control_mesh.h"

#include <cstddef>
#include <string>
#include <vector>

namespace stf {

/// Points with a width as a host hands them in, with the meaning of UsdGeomPoints. Plain values.
struct PointSet {
    std::vector<Vec3f> points;
    std::vector<float> widths; ///< diameters, object units: one for all or one each; empty: 1
    std::vector<Rgb> colors;   ///< displayColor, one for all or one each; empty: grey
    std::vector<int> hidden;   ///< numbers of points that are not drawn
};

/// What `tessellate` left out, and why.
struct PointRepairs {
    int badPoints = 0; ///< not finite
    int withoutWidth = 0;
    bool droppedWidths = false, droppedColors = false; ///< wrong count
    int nonFiniteColors = 0;                           ///< set to zero
    int everyNth = 1;     ///< to keep within the number of triangles, only every n-th point is there
    bool coarser = false; ///< for the same reason, drawn with fewer triangles than wanted
    /// One sentence, empty if nothing was left out.
    std::string summary() const;
};

/// Points as spheres of triangles, for a renderer of meshes. Scheme None, with the sphere's normals.
///
/// \p level 0 to 3: icosahedra split once to three times, 80, 320 or 1280 triangles each (3 is as 2). Each is scaled to
/// the sphere's area, so that the area that is seen is right, on average over all sides (Cauchy).
///
/// Never more than \p maxTriangles: first the detail goes down (to octahedra), then points are left out evenly.
/// Deterministic; never throws for what the points hold. Without usable points the mesh has no face.
ControlMesh tessellate(const PointSet& points, int level, std::size_t maxTriangles, PointRepairs& repairs);

} // namespace stf
