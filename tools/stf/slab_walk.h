// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "tools/stf/slab_result.h"

namespace stf {

/// Walks photons through the slab's true medium: the walks that tables are made of, without tables. Throws Cancelled.
SlabResult slabByWalks(const SlabOptions& options, Progress& progress);

/// Optical depth that stands for a half-infinite core: 40 diffusion lengths, at least 2000, at most 1e5 (where a nearly
/// white core still lets some light through, which counts as transmitted).
double slabCoreDepth(double albedo, double g);

} // namespace stf
