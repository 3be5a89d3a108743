// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/core/dipole.h"
#include "stfLib/shell/shell_grid.h"
#include "stfLib/surface/ray_scene.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/tile_medium.h"
#include "stfLib/volume/base_volume.h"

#include <memory>

namespace stf {

/// A mesh with a bound base volume, ready to be marched. Immutable once made.
struct ShellObject {
    std::shared_ptr<const BaseVolume> source; ///< as read from its file
    std::shared_ptr<const BaseVolume> volume; ///< cropped to the shell's depth; `source` where that is all of it
    std::shared_ptr<const StfTable> table;
    std::shared_ptr<const TileMedium> medium; ///< of the table's form
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
