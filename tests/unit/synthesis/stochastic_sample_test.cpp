// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/stochastic_sample.h"

#include "tests/unit/support/smooth_noise.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

// One layer of extinction values; `value(x, y)`.
template<class Value>
BaseVolume layer(int size, Value value) {
    BaseVolume v;
    v.size = {size, size, 1};
    v.voxelMm = Vec3d(0.1);
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            v.extinction.push_back(Rgb(value(x, y)));
            v.albedo.push_back(Rgb(0.9f));
        }
    }
    return v;
}

// A Gaussian random field of a correlation length in texels, through a skew function.
BaseVolume noise(double sigma) {
    const std::vector<float> values = smoothNoise({128, 128, 1}, Vec3d(1.0), sigma, 3);
    return layer(128, [&](int x, int y) { return std::exp(3 * float(sigma) * values[std::size_t(x + 128 * y)]); });
}

TEST(StochasticSample, NoiseOfAnyHistogramIsRandom) {
    for (double sigma : {1.0, 2.0, 3.0}) {
        const Randomness r = judgeRandomness(noise(sigma));
        EXPECT_TRUE(r.stochastic) << sigma << ": " << r.why;
    }
}

TEST(StochasticSample, VeinsCellsAndPatternsAreNot) {
    // Thin bright lines.
    const BaseVolume veins = layer(128, [](int x, int y) {
        const double s = std::sin(0.0490873852 * 2 * (x + 6 * std::sin(0.0490873852 * y)));
        return float(0.2 + 5 * std::exp(-30 * s * s));
    });
    EXPECT_FALSE(judgeRandomness(veins).stochastic) << judgeRandomness(veins).why;
    const BaseVolume checks = layer(128, [](int x, int y) { return (x / 8 + y / 8) % 2 ? 1.0f : 3.0f; });
    EXPECT_FALSE(judgeRandomness(checks).stochastic) << judgeRandomness(checks).why;
    const BaseVolume waves = layer(128, [](int x, int y) { return 2 + std::sin(0.3926990817f * float(x + y)); });
    EXPECT_FALSE(judgeRandomness(waves).stochastic) << judgeRandomness(waves).why;
}

TEST(StochasticSample, ReliefAndSmallSamplesAreNot) {
    BaseVolume relief = noise(1);
    relief.surface.assign(relief.voxelCount(), -0.1f);
    relief.surface[0] = 0.1f;
    EXPECT_FALSE(judgeRandomness(relief).stochastic);
    EXPECT_FALSE(judgeRandomness(layer(8, [](int, int) { return 1.0f; })).stochastic);
}

} // namespace
