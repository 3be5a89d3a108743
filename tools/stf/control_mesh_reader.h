// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/surface/refined_surface.h"

#include <string>

namespace stf {

/// All meshes of an OBJ, PLY, STL, OFF or USD file as one, without texture coordinates. `scheme`: none, loop or
/// catmullClark. Triangles turned against their neighbours are turned back, degenerate and repeated ones dropped; one
/// message tells of it. Throws Error with a message that starts with the path.
ControlMesh readControlMesh(const std::string& path, const std::string& scheme, const MessageSink& messages);

/// The same mended for refinement (sanitize) and refined: to a 150th of its diagonal, or not at all without a scheme.
/// Messages start with the path.
RefinedSurface readRefinedSurface(const std::string& path, const std::string& scheme, const MessageSink& messages);

/// Square object units.
double surfaceArea(const RefinedSurface& surface);

} // namespace stf
