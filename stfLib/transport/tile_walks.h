// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/lateral_filter.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/transport/walk_groups.h"

namespace stf {

/// What the stages of a precomputation share: the medium, the walks and what is done to the fields that they give.
class TileWalks {
public:
    TileWalks(const BaseVolume& baseVolume, const TransportOptions& transportOptions, Progress& progress);

    const BaseVolume& volume;
    const TransportOptions& options;
    const TileMedium medium;
    const std::size_t columns;
    WalkGroups walks;
    const double tileArea;          ///< mm^2
    std::uint64_t pilotPhotons = 0; ///< of each walk that only decides something
    LateralFilter filter;
    /// Errors of collided light count in relation to collided light, or to a tenth of all light where it is less than
    /// that: this is the share by which they count then, at most 1.
    double weight = 1;
    std::vector<float> fill; ///< share of each voxel that holds material; empty: all of all

    /// Takes groups [first, last) (all where last is 0) into the mean of earlier rounds: field * before + groups *
    /// scale
    /// * now.
    void mean(std::vector<float>& field, const std::vector<GroupResult>& r, std::vector<float> GroupResult::*of,
              float scale, float before, float now, int first = 0, int last = 0) const;

    /// Filters a field of any number of components per voxel and carries it into voxels without material next to a
    /// surface, which a lookup interpolates with.
    void finish(std::vector<float>& field, int components) const;
};

} // namespace stf
