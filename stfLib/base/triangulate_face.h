// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <vector>

namespace stf {

/// Triangulates one face, given by its corners in order: a shortest valid diagonal for quads, ear clipping for concave
/// polygons, a fan otherwise. Appends triples of local corner numbers; nothing for fewer than three corners.
void triangulateFace(const std::vector<Vec3d>& corners, std::vector<Vec3i>& out);

} // namespace stf
