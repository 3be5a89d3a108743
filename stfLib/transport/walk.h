// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/transport/tile_medium.h"

#include <cstdint>
#include <vector>

namespace stf {

/// What walks enter with. Each entering photon counts 1 before Fresnel.
struct WalkSource {
    enum class Kind {
        Direction,    ///< parallel light through the top, from `towardsLight` (outside)
        AnyAzimuth,   ///< the same, averaged over azimuth; fluxes are tallied in the light's frame (FactoredField)
        DiffuseTop,   ///< uniform radiance through the top, from outside
        DiffuseBelow, ///< uniform radiance through the bottom, from a medium of the same index (from outside where the
                      ///< bottom is open)
        Emission      ///< the medium's own emission; a photon counts 4 pi times the mean emission (TileMedium)
    };
    Kind kind = Kind::Direction;
    Vec3f towardsLight{0, 0, 1};
};

/// Which walks, and what of them is kept.
struct WalkRequest {
    std::uint64_t seed = 0, source = 0; ///< the result is a pure function of (seed, source, first, count)
    std::uint64_t first = 0, count = 0;
    bool voxels = true;      ///< tally fluence
    bool flux = false;       ///< and flux
    bool uncollided = false; ///< also before the first collision
    /// Radiance of collided light that leaves through the top towards here (tile frame, unit, z > 0), by next-event
    /// estimation; index 1, no relief. Zero: not wanted.
    Vec3f towardsViewer{0, 0, 0};
    bool analog = false; ///< photons die instead of losing weight: bookkeeping is exact, noise larger
    bool scalar = false; ///< photon after photon, where vectors could walk many at once (lane_walk.h): for comparison
};

/// Sums over walks, per unit of entering flux. Channels interleaved.
struct WalkTally {
    std::uint64_t photons = 0;
    int components = 0; ///< per voxel and channel: 0, 1 (fluence) or 4 (fluence, flux x, y, z; z outward)
    /// Per voxel: track length (mm) times (1, direction of travel) after the first collision, and before it;
    /// [voxel][rgb][component].
    std::vector<double> collided, uncollided;
    std::vector<double> below;                 ///< per column: weight leaving through the bottom after a collision
    std::vector<double> belowUncollided;       ///< per column: weight leaving through the bottom without one
    std::vector<double> belowUncollidedCosine; ///< the same times its cosine to the normal inside the medium
    /// Per column where light leaves through the top: what goes towards the viewer per unit solid angle, over its
    /// cosine. Radiance per outside perpendicular irradiance is this times cos(light) * columns / photons.
    std::vector<double> radiance;
    Vec3d above{0, 0, 0};    ///< weight leaving through the top, collided or not, reflected or not
    Vec3d specular{0, 0, 0}; ///< the part of `above` that never was inside the material
    Vec3d absorbed{0, 0, 0}; ///< weight absorbed at collisions, tallied on its own
    /// What roulette (and lost walks) took away less what it gave, zero in the mean (of roulette): above + below +
    /// absorbed + roulette = photons up to rounding, and without it within statistical error.
    Vec3d roulette{0, 0, 0};
    /// Sums over photons of the squares of what each gave: the statistical error of the totals.
    Vec3d aboveSquared{0, 0, 0}, belowSquared{0, 0, 0}, absorbedSquared{0, 0, 0};
    std::uint64_t collisions = 0;
    std::uint64_t lost = 0; ///< walks that never ended (parallel to the layers in a void): dropped

    void add(const WalkTally& other);
};

/// Walks photons through a tile: exact free flights through piecewise-constant voxels by inverting the accumulated
/// optical depth, track-length estimators, implicit capture with unbiased roulette, refraction and internal reflection
/// at the flat top, an open bottom and the relief's surface. With one extinction for all channels one walk carries rgb;
/// otherwise each distinct channel is walked by itself: no spectral weights, hence none that could grow. Throws
/// Cancelled. Thread-safe.
WalkTally walk(const TileMedium& medium, const WalkSource& source, const WalkRequest& request,
               const Progress& progress);

} // namespace stf
