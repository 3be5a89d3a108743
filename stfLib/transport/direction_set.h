// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// Up to four directions of a set and their weights (not negative; their sum is below 1 near grazing light).
struct DirectionWeights {
    int index[4];
    float weight[4];
    int count = 0; ///< 0: no light from there
};

/// The light directions of a table: polar nodes 0, d, 2d, ... below 90 degrees and `azimuths` nodes around, in the
/// frame (tangent, bitangent, outward normal) of the tile. One azimuth means: averaged over azimuth. At 90 degrees the
/// table is zero, since it is stored per perpendicular irradiance. Index = polar * azimuths + azimuth, polar 0
/// included.
class DirectionSet {
public:
    DirectionSet() = default;
    DirectionSet(int polars, int azimuths);

    int polars() const { return polars_; }
    int azimuths() const { return azimuths_; }
    int count() const { return polars_ * azimuths_; }
    /// Unit vector towards the light; z outward.
    Vec3f direction(int index) const;
    float polarAngle(int index) const { return float(index / azimuths_) * step_; }

    /// Linear in the polar angle, periodic linear in azimuth. `towardsLight` is a unit vector in the tile's frame.
    DirectionWeights weights(const Vec3f& towardsLight) const;

private:
    int polars_ = 0, azimuths_ = 1;
    float step_ = 0; ///< radians between polar nodes
};

} // namespace stf
