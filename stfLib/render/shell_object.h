// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/core/dipole.h"
#include "stfLib/shell/shell_grid.h"
#include "stfLib/surface/ray_scene.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/walk.h"
#include "stfLib/volume/base_volume.h"

#include <memory>
#include <vector>

namespace stf {

/// What the march reads of one voxel, together in memory.
struct VoxelMedium {
    Rgb extinction; ///< 1/mm
    Rgb scattering; ///< 1/mm
    float g;
};

/// A mesh with a bound base volume, ready to be marched. Immutable once made.
struct ShellObject {
    std::shared_ptr<const BaseVolume> volume;
    std::shared_ptr<const StfTable> table;
    std::shared_ptr<const WalkMedium> medium; ///< for exact optical depths
    std::vector<VoxelMedium> voxels;
    RefinedSurface surface;
    ExemplarMap map;
    ShellBoundary boundary;
    ShellGrid grid;
    std::shared_ptr<const RayMesh> rayMesh;
    CoreMaterial core;
    bool coreBlack = true;
    float mmPerUnit = 1; ///< tile millimetres per object unit
    float thicknessMm = 0;
    float blurRadiusMm = 0; ///< over which visibility is averaged for multiple scattering (DESIGN 3.12)
};

} // namespace stf
