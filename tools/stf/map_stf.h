// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/volume/base_volume.h"
#include "tools/stf/map_result.h"

namespace stf {

/// The map as the renderer computes it: a table is precomputed, written and read, and the radiance that leaves is
/// marched at random points of each column. The errors are those of the march: the table's own, which columns share, is
/// told apart. Throws Error, Cancelled.
MapResult mapByTable(const BaseVolume& volume, const MapOptions& options, Progress& progress);

} // namespace stf
