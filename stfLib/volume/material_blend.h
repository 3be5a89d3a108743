// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/optics/material.h"
#include "stfLib/volume/base_volume.h"

#include <vector>

namespace stf {

/// Fills extinction, albedo, g and ior of a volume (size and voxelMm given) from volume fractions: `fractions` holds
/// for each voxel (x fastest) one number per material, >= 0, of sum <= 1; what is missing to 1 is empty. Scattering and
/// absorption coefficients add up by volume, never albedo alone; g is the mean weighted with scattering; ior that of
/// the materials present, weighted with their fractions. Where `volume.surface` is given, voxels that it may cut (nearer
/// than half their diagonal) hold the coefficients of the material inside (the surface alone says where material is,
/// docs/base_volume.md): their fractions are divided by their sum. Arrays that are all 0 (g) or all 1 (ior) are left
/// out. Throws Error on sizes that do not fit, negative or not finite fractions.
void blendMaterials(BaseVolume& volume, const std::vector<Material>& materials, const std::vector<float>& fractions);

} // namespace stf
