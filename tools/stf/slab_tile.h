// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"
#include "tools/stf/slab_options.h"

namespace stf {

/// A slab as a tile of one column. Only optical depth matters between planes, so all voxels are 1 mm high and hold what
/// optical depth they should: thin ones near faces and between layers, where fluence bends, thick ones deep inside.
struct SlabTile {
    BaseVolume volume;
    std::vector<double> edges; ///< optical depths of the true medium between voxels, from 0
};

/// Voxels of 0.04 mean free paths of the form's medium at faces, up to 0.4 from some 4 on, then a twentieth of the
/// distance from the face.
SlabTile makeSlabTile(const SlabOptions& options);

} // namespace stf
