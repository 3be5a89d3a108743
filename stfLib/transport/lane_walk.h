// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/walk.h"

namespace stf {

/// Which vector instructions walk. All give the same numbers, to the last bit.
enum class LaneInstructions { Best, Plain, Avx2, Avx512 };
/// Whether this build and this processor have them.
bool available(LaneInstructions instructions);

/// Whether `walkLanes` can do what is asked of a walk: totals and columns alone, no viewer, no analog absorption, no
/// relief, one index of refraction; and whether it pays: in a tile, extinction is not so uneven that most steps of
/// delta tracking would be null collisions.
bool lanesCanWalk(const TileMedium& medium, const WalkSource& source, const WalkRequest& request);

/// The same walks as `walk` (walk.h), many photons side by side in vector instructions, for one channel; adds to the
/// sums of `tally` (photons and channels like this one are the caller's). A single column is walked in optical depth,
/// where neither voxels nor voids cost anything. A tile of several columns is walked by delta tracking (Woodcock et al.
/// 1965) over its largest extinction: as exact as flights from voxel to voxel, and with less to do per step.
///
/// Positions, weights and sums are double, directions and free flights float. A photon's path is a function of
/// (seed, source, its number); sums are added in an order that `first` and `count` alone decide, and the arithmetic
/// is the same for every instruction set. Throws Cancelled. Thread-safe.
void walkLanes(const TileMedium& medium, const WalkSource& source, const WalkRequest& request, int channel,
               WalkTally& tally, const Progress& progress, LaneInstructions instructions = LaneInstructions::Best);

} // namespace stf
