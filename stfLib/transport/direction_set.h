// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <vector>

namespace stf {

/// The directions of a set that a lookup reads, and their weights: their sum is 1 but near grazing light, some are
/// negative.
struct DirectionWeights {
    int index[16];
    float weight[16];
    int count = 0; ///< 0: no light from there
    /// So many at the end lie across the pole: seen from there, what is radial or tangential has the other sign.
    int across = 0;
};

/// The light directions of a table: polar angles 0, d, 2d, ... below 90 degrees; one node at the pole, `azimuths` nodes
/// around on every other ring, in the frame (tangent, bitangent, outward normal) of the tile. One azimuth means:
/// averaged over azimuth. At 90 degrees the table is zero, since it is stored per perpendicular irradiance.
/// Index 0 is the pole, then ring after ring. Under a flat top that refracts, what is interpolated is the light that
/// enters: values over 1 - F, without Fresnel's steep fall towards grazing light.
class DirectionSet {
public:
    DirectionSet() = default;
    /// `polars` >= 1 counts the pole; `azimuths` is 1 or even (odd ones become the next). `topIor`: index of a flat top
    /// (TileMedium::topIor).
    DirectionSet(int polars, int azimuths, float topIor = 1);

    int polars() const { return polars_; }
    int azimuths() const { return azimuths_; }
    float topIor() const { return topIor_; }
    int count() const { return polars_ > 0 ? 1 + (polars_ - 1) * azimuths_ : 0; }
    /// Unit vector towards the light; z outward.
    Vec3f direction(int index) const;
    float polarAngle(int index) const { return float(ring(index)) * step_; }
    int ring(int index) const { return index == 0 ? 0 : 1 + (index - 1) / azimuths_; }

    /// Lagrange's cubic through four rings (through the pole onto the other side; one-sided at grazing light) and, on
    /// each, through four azimuths. `towardsLight` is a unit vector in the tile's frame. Exact at the nodes.
    DirectionWeights weights(const Vec3f& towardsLight) const;

private:
    int polars_ = 0, azimuths_ = 1;
    float step_ = 0; ///< radians between rings
    float topIor_ = 1;
    std::vector<float> entering_; ///< 1 - F of each ring; empty where nothing is refracted
};

} // namespace stf
