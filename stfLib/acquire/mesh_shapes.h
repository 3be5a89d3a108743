// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_recipe.h"

namespace stf {

/// A closed mesh of a shape that needs no file (docs/acquire_mesh.md), in the coordinates of a recipe. Round shapes
/// have the volume of what they stand for, whatever their number of triangles (20 * 4^detail for a sphere).
TriangleMesh makeShape(const MeshSource& source, const Vec3d& extentMm, int detail);

/// The map from a mesh's own coordinates into those of the recipe (mm, z outward).
Transform placementOf(const MeshPlacement& placement, const TriangleMesh& mesh, const Vec3d& extentMm);
/// The same for a relief, whose `fit` stretches it over the tile and brings its top to z = 0.
Transform reliefPlacementOf(const MeshPlacement& placement, const TriangleMesh& mesh, const Vec3d& extentMm);

} // namespace stf
