// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/volume/base_volume.h"

#include <cstdint>
#include <vector>

namespace stf {

/// What walks enter with.
struct WalkSource {
    enum class Kind {
        Direction,   ///< parallel light through the top, from `towardsLight`
        AnyAzimuth,  ///< the same, averaged over azimuth
        DiffuseTop,  ///< uniform radiance through the top
        DiffuseBelow ///< uniform radiance through the bottom
    };
    Kind kind = Kind::Direction;
    Vec3f towardsLight{0, 0, 1};
};

/// Sums over walks, per unit of entering flux (each entering photon counts 1). Channels interleaved.
struct WalkTally {
    std::uint64_t photons = 0;
    std::vector<double> uncollided;      ///< per voxel: track length (mm) before the first collision
    std::vector<double> collided;        ///< per voxel: track length (mm) after it
    std::vector<double> below;           ///< per column: weight leaving through the bottom after a collision
    std::vector<double> belowUncollided; ///< per column: weight leaving through the bottom without one
    Vec3d above{0, 0, 0};                ///< weight leaving through the top, collided or not
    Vec3d absorbed{0, 0, 0};             ///< weight absorbed, tallied on its own: above + below + absorbed = photons
    std::uint64_t collisions = 0;
    std::uint64_t lost = 0; ///< walks that never ended (parallel to the layers in a void): dropped

    void add(const WalkTally& other);
};

/// The medium as walks see it. With one extinction for all channels one walk carries rgb; otherwise each channel is
/// walked by itself: no spectral weights, hence none that could grow.
class WalkMedium {
public:
    explicit WalkMedium(const BaseVolume& volume);

    /// Walks photons [first, first + count), numbered within the source: the result is a pure function of (seed, source
    /// number, range). Exact free flights through piecewise-constant voxels by inverting the accumulated optical depth;
    /// track-length estimators; implicit capture with unbiased roulette. Throws Cancelled. Thread-safe.
    WalkTally walk(const WalkSource& source, std::uint64_t seed, std::uint64_t sourceNumber, std::uint64_t first,
                   std::uint64_t count, const Progress& progress) const;

    const Vec3i& size() const { return size_; }
    const Vec3d& voxelMm() const { return voxelMm_; }
    bool greyExtinction() const { return grey_; }
    /// Optical depth from the middle of a column's bottom face, or any point (voxel units), to the top along the
    /// direction towards the light.
    Rgb opticalDepth(const Vec3f& position, const Vec3f& towardsLight) const;

private:
    template<int Channels>
    void walkChannels(const WalkSource& source, std::uint64_t seed, std::uint64_t sourceNumber, std::uint64_t first,
                      std::uint64_t count, int channel, const Progress& progress, WalkTally& tally) const;

    Vec3i size_;
    Vec3d voxelMm_;
    bool grey_ = true;
    std::vector<float> extinction_[3]; ///< one array where grey
    std::vector<Rgb> albedo_;
    std::vector<float> g_;
};

} // namespace stf
