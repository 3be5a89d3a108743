// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/walk.h"
#include "tests/unit/support/statistics.h"
#include "tests/unit/volume/volumes.h"

#include <string>

namespace stf::test {

constexpr double kPi = 3.14159265358979323846;

/// What most tests ask of walks: fluence before and after the first collision. The caller sets count, first and seed.
inline WalkRequest fluenceRequest(std::uint64_t photons = 0, std::uint64_t seed = 1) {
    WalkRequest r;
    r.seed = seed;
    r.count = photons;
    r.uncollided = true;
    return r;
}
/// Totals alone.
inline WalkRequest totalsRequest(std::uint64_t photons = 0, std::uint64_t seed = 1) {
    WalkRequest r;
    r.seed = seed;
    r.count = photons;
    r.voxels = false;
    return r;
}

/// The volume in its true medium.
inline TileMedium trueMedium(const BaseVolume& v, bool openBottom = false) {
    return TileMedium(v, TransportForm::Classic, openBottom);
}

inline WalkTally walkOnce(const TileMedium& medium, const WalkSource& source, const WalkRequest& request) {
    const Progress progress;
    return walk(medium, source, request, progress);
}
inline WalkTally walkOnce(const TileMedium& medium, const WalkSource& source, std::uint64_t photons,
                          std::uint64_t seed = 1) {
    return walkOnce(medium, source, fluenceRequest(photons, seed));
}

/// Independent batches of walks of one source.
inline std::vector<WalkTally> walkBatches(const TileMedium& medium, const WalkSource& source, int batches,
                                          std::uint64_t photonsPerBatch, WalkRequest request = fluenceRequest()) {
    return runBatches(batches, [&](int b) {
        WalkRequest mine = request;
        mine.first = std::uint64_t(b) * photonsPerBatch;
        mine.count = photonsPerBatch;
        return walkOnce(medium, source, mine);
    });
}

inline WalkSource normalLight() {
    return {};
}
inline WalkSource diffuse(WalkSource::Kind kind) {
    WalkSource s;
    s.kind = kind;
    return s;
}
/// Parallel light at a cosine to the normal, from +x.
inline WalkSource obliqueLight(double mu, WalkSource::Kind kind = WalkSource::Kind::Direction) {
    WalkSource s = diffuse(kind);
    s.towardsLight = Vec3f(float(std::sqrt(1 - mu * mu)), 0, float(mu));
    return s;
}

/// Sum of one channel of a tally's array.
inline double channelSum(const std::vector<double>& values, int channel) {
    double sum = 0;
    for (std::size_t i = std::size_t(channel); i < values.size(); i += 3) {
        sum += values[i];
    }
    return sum;
}

/// Weight that left through the bottom, collided or not; as a share of the photons like the next three.
inline double transmittance(const WalkTally& t, int c = 0) {
    return (channelSum(t.below, c) + channelSum(t.belowUncollided, c)) / double(t.photons);
}
inline double transmittedUncollided(const WalkTally& t, int c = 0) {
    return channelSum(t.belowUncollided, c) / double(t.photons);
}
inline double reflectance(const WalkTally& t, int c = 0) {
    return t.above[c] / double(t.photons);
}
inline double absorptance(const WalkTally& t, int c = 0) {
    return t.absorbed[c] / double(t.photons);
}

/// Exponential integral E_n(x) = INT_1^inf exp(-x t) / t^n dt = INT_0^1 mu^(n-2) exp(-x / mu) dmu, n >= 2.
inline double expIntegral(int n, double x) {
    const int steps = 20000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double mu = (i + 0.5) / steps;
        sum += std::pow(mu, n - 2) * std::exp(-x / mu) / steps;
    }
    return sum;
}

/// Relative bookkeeping error: what came in, went out, stayed or was taken by roulette.
constexpr double kRounding = 2e-7;
inline double imbalance(const WalkTally& t, int c = 0) {
    return std::abs(reflectance(t, c) + transmittance(t, c) + absorptance(t, c) + t.roulette[c] / double(t.photons) -
                    1);
}

/// Standard error of a total, from the squares of what each photon gave.
inline double standardError(double sum, double squares, std::uint64_t photons) {
    const double n = double(photons), mean = sum / n;
    return std::sqrt(std::max(0.0, squares / n - mean * mean) / n);
}

} // namespace stf::test
