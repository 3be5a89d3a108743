// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/tile_medium.h"

#include <memory>

namespace stf {

/// A tile and its table with `factor` times `factor` columns made one: what a camera sees from so far away that a
/// voxel is less than its pixel's footprint.
struct CoarseTile {
    int factor = 1;
    std::shared_ptr<const TileMedium> medium;
    std::shared_ptr<const StfTable> table; ///< the parts that a camera march reads; the rest is empty
};

/// Whether columns can be made one at all: the tile has no surface (a relief's normals have no mean), its columns
/// differ, and `factor` divides both of its sides into two columns or more.
bool canCoarsen(const BaseVolume& volume, const TileMedium& medium, int factor);

/// Means over blocks of columns, layer by layer: of scattering and absorption coefficients, of the mean cosine by
/// scattering, of the light in the table by the scattering that it meets, so that each block scatters as much light as
/// its voxels did. Attenuation is that of the mean extinction: exact in the limit of voxels much thinner than a mean
/// free path, darker or brighter otherwise (measured by render/tile_pyramid). Throws Error where `canCoarsen` is false
/// or the table does not belong to the volume. `backlight`: whether light of a core will be read as well.
CoarseTile coarsenTile(const BaseVolume& volume, const TileMedium& medium, const StfTable& table, int factor,
                       bool backlight);

} // namespace stf
