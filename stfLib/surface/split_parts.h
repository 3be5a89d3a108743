// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/refined_surface.h"

#include <vector>

namespace stf {

/// The triangles of some faces of a surface, with the points, normals and coordinates that the whole has there.
struct SurfacePart {
    RefinedSurface surface;
    int number = 0; ///< of the faces, in `faceParts`
};

/// Cuts a surface along the borders of parts: `faceParts` has a number for each face of the control mesh (empty: all
/// are 0). Parts without a triangle are left out, the others come by growing number. Normals stay those of the whole,
/// so that no edge shows where two parts meet; `triangleFace` goes on naming the control mesh's faces.
std::vector<SurfacePart> splitByPart(RefinedSurface whole, const std::vector<int>& faceParts);

} // namespace stf
