// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/walk.h"
#include "tests/unit/support/statistics.h"
#include "tests/unit/volume/volumes.h"

namespace stf::test {

constexpr double kPi = 3.14159265358979323846;

/// Independent batches of walks of one source.
inline std::vector<WalkTally> walkBatches(const WalkMedium& medium, const WalkSource& source, int batches,
                                          std::uint64_t photonsPerBatch, std::uint64_t seed = 1) {
    const Progress progress;
    return runBatches(batches, [&](int b) {
        return medium.walk(source, seed, 0, std::uint64_t(b) * photonsPerBatch, photonsPerBatch, progress);
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

/// Relative bookkeeping error: what came in, went out or stayed. Weights are floats, so a few 1e-8 are rounding.
constexpr double kRounding = 2e-7;
inline double imbalance(const WalkTally& t, int c = 0) {
    return std::abs(reflectance(t, c) + transmittance(t, c) + absorptance(t, c) - 1);
}

} // namespace stf::test
