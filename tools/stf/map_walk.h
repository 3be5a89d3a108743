// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/volume/base_volume.h"
#include "tools/stf/map_result.h"

namespace stf {

/// Throws Error where a map cannot be made of a volume: relief, an index other than 1, emission.
void requireFlatTile(const BaseVolume& volume);

/// The map by walks through the true medium, seen by next-event estimation. The errors are those of independent
/// batches. Throws Error, Cancelled.
MapResult mapByWalks(const BaseVolume& volume, const MapOptions& options, Progress& progress);

} // namespace stf
