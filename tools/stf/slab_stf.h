// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "tools/stf/slab_result.h"

namespace stf {

/// Light through the slab as the renderer computes it: a tile is written, read and precomputed, its table written and
/// read, and the radiance that leaves is marched by TileMarch, lit by MarchLight, over a core of Dipole's albedos. The
/// standard errors are those of independent tables. Throws Cancelled, Error.
SlabResult slabByTable(const SlabOptions& options, Progress& progress);

} // namespace stf
