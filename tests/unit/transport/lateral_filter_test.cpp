// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/lateral_filter.h"

#include "stfLib/base/random.h"
#include "tests/unit/volume/volumes.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

std::vector<Rgb> noise(std::size_t count, std::uint64_t seed) {
    CounterRng rng(seed, 0);
    std::vector<Rgb> values(count);
    for (Rgb& v : values) {
        v = {rng.uniform(), rng.uniform(), rng.uniform()};
    }
    return values;
}

// Mean and standard deviation of a channel.
Vec2d moments(const std::vector<Rgb>& values, int channel) {
    double sum = 0, squares = 0;
    for (const Rgb& v : values) {
        sum += double(v[channel]);
        squares += double(v[channel]) * double(v[channel]);
    }
    const double mean = sum / double(values.size());
    return {mean, std::sqrt(squares / double(values.size()) - mean * mean)};
}

TEST(LateralFilter, KeepsTheMeanAndReducesNoiseAsItSays) {
    // Mean free paths of 0.25 to 8 voxels; 32768 values make the measured gain good to 1 %.
    for (float extinction : {4.0f, 1.0f, 0.5f, 0.125f}) {
        const BaseVolume v = homogeneous({32, 32, 32}, {1, 1, 1}, Rgb(extinction), Rgb(0.9f));
        const LateralFilter filter(v);
        std::vector<Rgb> values = noise(v.voxelCount(), 4);
        const std::vector<Rgb> before = values;
        filter.apply(values);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(moments(values, c).x, moments(before, c).x, 1e-6);
            EXPECT_NEAR(moments(before, c).y / moments(values, c).y / filter.noiseGain(), 1, 0.03) << extinction;
        }
        EXPECT_GE(filter.noiseGain(), 1);
    }
}

TEST(LateralFilter, AtMostOneAndAHalfVoxels) {
    const LateralFilter wide(homogeneous({32, 32, 2}, {1, 1, 1}, Rgb(1e-3f), Rgb(0.9f)));
    EXPECT_NEAR(wide.noiseGain(), 2 * std::sqrt(3.14159265) * 1.5, 0.05); // of a Gaussian of that width
    const LateralFilter dense(homogeneous({32, 32, 2}, {1, 1, 1}, Rgb(100.0f), Rgb(0.9f)));
    EXPECT_EQ(dense.noiseGain(), 1);
}

TEST(LateralFilter, IsPeriodicAndSymmetric) {
    const Vec3i size(16, 12, 3);
    const BaseVolume v = homogeneous(size, {1, 1, 1}, Rgb(0.8f), Rgb(0.9f));
    const LateralFilter filter(v);
    std::vector<Rgb> values(v.voxelCount(), Rgb(0.0f));
    values[v.index(0, 0, 1)] = Rgb(1.0f);
    filter.apply(values);
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            EXPECT_EQ(values[v.index(x, y, 0)], Rgb(0.0f)) << "depth is not filtered";
            EXPECT_EQ(values[v.index(x, y, 2)], Rgb(0.0f));
            EXPECT_EQ(values[v.index(x, y, 1)], values[v.index((16 - x) % 16, (12 - y) % 12, 1)]);
        }
    }
    EXPECT_GT(values[v.index(15, 0, 1)].x, 0);
    EXPECT_GT(values[v.index(0, 11, 1)].x, 0);
    // A constant stays.
    std::vector<Rgb> constant(v.voxelCount(), Rgb(3.0f));
    filter.apply(constant);
    for (const Rgb& c : constant) {
        EXPECT_NEAR(c.y, 3, 1e-5f);
    }
}

TEST(LateralFilter, LeavesOneColumnAlone) {
    const BaseVolume v = homogeneous({1, 1, 8}, {1, 1, 1}, Rgb(0.5f), Rgb(0.9f));
    const LateralFilter filter(v);
    EXPECT_EQ(filter.noiseGain(), 1);
    std::vector<Rgb> values = noise(8, 1);
    const std::vector<Rgb> before = values;
    filter.apply(values);
    EXPECT_TRUE(values == before);
}

TEST(LateralFilter, WidthFollowsTheTransportMeanFreePath) {
    const double plain = LateralFilter(homogeneous({32, 32, 2}, {1, 1, 1}, Rgb(2.0f), Rgb(0.9f))).noiseGain();
    const double forward = LateralFilter(homogeneous({32, 32, 2}, {1, 1, 1}, Rgb(4.0f), Rgb(0.9f), 0.5f)).noiseGain();
    EXPECT_NEAR(plain, forward, 1e-6);
    // In voxels: half the voxel, twice the width; only along x.
    const double fine = LateralFilter(homogeneous({32, 32, 2}, {0.5, 1, 1}, Rgb(2.0f), Rgb(0.9f))).noiseGain();
    EXPECT_GT(fine, 1.2 * plain);
    // Voids do not count.
    BaseVolume half = homogeneous({32, 32, 2}, {1, 1, 1}, Rgb(2.0f), Rgb(0.9f));
    std::fill(half.extinction.begin(), half.extinction.begin() + 1024, Rgb(0.0f));
    EXPECT_NEAR(LateralFilter(half).noiseGain(), plain, 1e-6);
    EXPECT_EQ(LateralFilter(homogeneous({32, 32, 2}, {1, 1, 1}, Rgb(0.0f), Rgb(0.9f))).noiseGain(), 1);
}

} // namespace
