// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/lateral_filter.h"

#include "stfLib/base/random.h"

#include <gtest/gtest.h>
#include <numeric>

using namespace stf;

namespace {

std::vector<float> noise(std::size_t count, std::uint64_t seed) {
    CounterRng rng(seed, 0);
    std::vector<float> values(count);
    for (float& v : values) {
        v = rng.uniform();
    }
    return values;
}

double mean(const std::vector<float>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
}

double deviation(const std::vector<float>& v) {
    const double m = mean(v);
    double squares = 0;
    for (float x : v) {
        squares += (double(x) - m) * (double(x) - m);
    }
    return std::sqrt(squares / double(v.size()));
}

TEST(LateralFilter, KeepsTheMeanAndReducesNoiseAsAGaussianDoes) {
    for (const double sigma : {0.75, 1.0, 1.5}) {
        const LateralFilter filter({32, 32, 32}, {1, 1, 1}, sigma);
        std::vector<float> values = noise(32 * 32 * 32, 4);
        const std::vector<float> before = values;
        filter.apply(values, 1, {});
        EXPECT_NEAR(mean(values), mean(before), 1e-6);
        // White noise falls by 2 sqrt(pi) sigma in two dimensions, for widths that the samples resolve.
        EXPECT_NEAR(deviation(before) / deviation(values) / (2 * std::sqrt(3.14159265) * sigma), 1, 0.05) << sigma;
    }
}

TEST(LateralFilter, IsPeriodicSymmetricAndWithinALayer) {
    const Vec3i size(16, 12, 3);
    const LateralFilter filter(size, {1, 1, 1}, 1.2);
    const auto index = [&](int x, int y, int z) { return std::size_t(x + size.x * (y + size.y * z)); };
    std::vector<float> values(16 * 12 * 3, 0.0f);
    values[index(0, 0, 1)] = 1;
    filter.apply(values, 1, {});
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            EXPECT_EQ(values[index(x, y, 0)], 0) << "depth is not filtered";
            EXPECT_EQ(values[index(x, y, 2)], 0);
            EXPECT_NEAR(values[index(x, y, 1)], values[index((16 - x) % 16, (12 - y) % 12, 1)], 1e-7f);
        }
    }
    EXPECT_GT(values[index(15, 0, 1)], 0);
    EXPECT_GT(values[index(0, 11, 1)], 0);
}

TEST(LateralFilter, ComponentsAreFilteredAlike) {
    const Vec3i size(8, 6, 2);
    const LateralFilter filter(size, {1, 2, 1}, 1.0);
    std::vector<float> one = noise(96, 1), three;
    for (float v : one) {
        three.insert(three.end(), {v, 2 * v, -v});
    }
    filter.apply(one, 1, {});
    filter.apply(three, 3, {});
    for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_NEAR(three[3 * i], one[i], 1e-6f);
        EXPECT_NEAR(three[3 * i + 1], 2 * one[i], 1e-6f);
        EXPECT_NEAR(three[3 * i + 2], -one[i], 1e-6f);
    }
}

TEST(LateralFilter, EmptyVoxelsDoNotCount) {
    const Vec3i size(8, 8, 1);
    const LateralFilter filter(size, {1, 1, 1}, 1.0);
    std::vector<float> values(64, 3.0f), fill(64, 1.0f);
    for (int i = 0; i < 64; i += 3) {
        fill[std::size_t(i)] = 0;
        values[std::size_t(i)] = 1e6f;
    }
    filter.apply(values, 1, fill);
    for (float v : values) {
        EXPECT_NEAR(v, 3, 1e-5f) << "a constant stays, and reaches empty voxels";
    }
}

TEST(LateralFilter, NoneWhereItIsTooNarrowOrTheTileToo) {
    EXPECT_TRUE(LateralFilter().none());
    EXPECT_TRUE(LateralFilter({8, 8, 8}, {1, 1, 1}, 0.1).none());
    EXPECT_TRUE(LateralFilter({1, 1, 8}, {1, 1, 1}, 2.0).none());
    std::vector<float> values = noise(8, 1);
    const std::vector<float> before = values;
    LateralFilter({1, 1, 8}, {1, 1, 1}, 2.0).apply(values, 1, {});
    EXPECT_TRUE(values == before);
    // Voxels of different width: in millimetres it is as wide along both.
    const LateralFilter stretched({32, 32, 1}, {0.5, 5, 1}, 0.75);
    EXPECT_FALSE(stretched.none());
    std::vector<float> spike(1024, 0.0f);
    spike[0] = 1;
    stretched.apply(spike, 1, {});
    EXPECT_GT(spike[1], 0);
    EXPECT_EQ(spike[32], 0);
}

} // namespace
