// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_recipe.h"

namespace stf {

/// What is scattered, in the coordinates of a recipe.
struct ScatteredBody {
    Vec3d middle;      ///< copies are turned and scaled about it
    double radius = 0; ///< of a sphere about it that holds all of it
    double volume = 0; ///< mm^3
};

struct ScatterResult {
    std::vector<Transform> copies; ///< of the placed mesh
    std::size_t leftOut = 0;       ///< for which no place was found
};

/// Random places in a tile that repeats along x and y, uniform in volume, sizes uniform in their range, directions
/// uniform on the sphere. Deterministic by the seed; the first n of `count` copies are those of a `count` of n unless
/// they are kept apart. Throws Error where a `fraction` would need absurdly many.
ScatterResult scatter(const MeshScatter& options, const ScatteredBody& body, const Vec3d& extentMm);

} // namespace stf
