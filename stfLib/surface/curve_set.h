// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/surface/control_mesh.h"

#include <cstddef>
#include <string>
#include <vector>

namespace stf {

/// Curves with a width as a host hands them in, with the meaning that they have in UsdGeomBasisCurves. Plain values.
struct CurveSet {
    enum class Basis { Linear, Bezier, BSpline, CatmullRom };
    /// Pinned: B-splines and Catmull-Rom curves that begin and end in their first and last point. Segmented: linear
    /// ones, each two points a piece.
    enum class Wrap { Nonperiodic, Periodic, Pinned, Segmented };
    enum class Interpolation { Constant, Uniform, Varying, Vertex };
    template<class T>
    struct Primvar {
        std::vector<T> values;
        Interpolation interpolation = Interpolation::Constant;
    };

    Basis basis = Basis::Linear;
    Wrap wrap = Wrap::Nonperiodic;
    std::vector<int> vertexCounts;
    std::vector<int> indices; ///< which point each vertex is; empty: one after the other
    std::vector<int> hidden;  ///< numbers of curves that are not drawn
    std::vector<Vec3f> points;
    Primvar<float> widths; ///< diameters, object units; empty: 1
    Primvar<Rgb> colors;   ///< displayColor; empty: grey
    /// Where there are any, curves are flat ribbons that face along them, else round.
    Primvar<Vec3f> normals;

    /// How many values a primvar of that interpolation has.
    std::size_t valueCount(Interpolation interpolation) const;
};

/// What `tessellate` left out, and why.
struct CurveRepairs {
    int wrongCounts = 0;   ///< curves whose number of vertices does not fit basis and wrap, or is not there
    int badPoints = 0;     ///< curves with points that are not there or not finite
    int withoutExtent = 0; ///< curves of no length or no width
    bool droppedWidths = false, droppedColors = false, droppedNormals = false; ///< wrong count
    int nonFiniteValues = 0; ///< widths, colours and normals that are not finite or, of widths, negative: zero
    int everyNth = 1;        ///< to keep within the number of triangles, only every n-th curve is there
    bool coarser = false;    ///< for the same reason, drawn with less than the detail asked for
    /// One sentence, empty if nothing was left out.
    std::string summary() const;
};

/// Curves as polygons, for a renderer of meshes: round ones as closed tubes, those with normals as ribbons. Scheme
/// None, with smooth normals.
///
/// \p level 0 to 3: tubes of 4, 6, 8 or 12 sides, and 2, 4, 6 or 8 pieces to a cubic span. A piece of a span is off its
/// curve by at most |C''| / (8 pieces^2), with C'' the curve's second derivative over the span. The polygon of a cross
/// section has the circle's perimeter: lateral area and the width seen from all sides on average are right (Cauchy),
/// corners stand out by 11, 5, 3 or 1 % of the radius.
///
/// Never more than \p maxTriangles: first the detail goes down (to 3 sides and 1 piece), then curves are left out
/// evenly. Deterministic; never throws for what the curves hold. Without usable curves the mesh has no face.
ControlMesh tessellate(const CurveSet& curves, int level, std::size_t maxTriangles, CurveRepairs& repairs);

} // namespace stf
