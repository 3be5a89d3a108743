// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/direction_set.h"
#include "stfLib/transport/walk_groups.h"

namespace stf {

struct DirectionChoice {
    DirectionSet set;
    double error = 0; ///< measured: rms of interpolated less walked fluence over the rms fluence
};

/// Chooses how finely light directions are sampled: pilot walks at directions between the nodes are compared with what
/// the nodes interpolate, free of the walks' noise (group_statistics.h), on fluence averaged over layers (polar) or
/// blocks of 2 x 2 x 2 voxels (azimuth). The smallest set within `tolerance` is taken, the finest known where none is.
/// `polars` or `azimuths` above 0 are given and only measured.
DirectionChoice chooseDirections(const TileMedium& medium, WalkGroups& walks, double tolerance, int polars,
                                 int azimuths, std::uint64_t photons);

/// The source of walks for a node of a set.
WalkSource sourceOf(const DirectionSet& set, int node);

} // namespace stf
