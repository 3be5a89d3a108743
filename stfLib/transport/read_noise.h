// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/lateral_filter.h"
#include "stfLib/transport/walk_groups.h"

namespace stf {

/// Fluence at some points of a tile, group by group, [group][point * rgb]: one in every voxel of a few pairs of layers,
/// spread over the depth; the same for all groups, whose scatter is the noise.
struct ReadGroups {
    std::vector<std::vector<float>> read;   ///< filtered and interpolated between voxels as a lookup does: what is seen
    std::vector<std::vector<float>> voxels; ///< filtered: what is stored
};
ReadGroups readGroups(const TileMedium& medium, const std::vector<GroupResult>& groups, int components,
                      const LateralFilter& filter);

} // namespace stf
