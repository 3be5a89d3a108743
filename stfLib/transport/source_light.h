// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/stf_table.h"
#include "stfLib/transport/tile_walks.h"

namespace stf {

/// Fills what light from the core does in the tile: `backlight`, `reflectedBelow`, `transmittedUp`. Without scattering
/// and refraction all of it passes, and nothing is walked.
void lightFromBelow(TileWalks& c, StfTable& t);

/// Fills what the volume's own emission does: `emitted`, `emittedBelow`; nothing where it has none.
void lightFromEmission(TileWalks& c, StfTable& t);

} // namespace stf
