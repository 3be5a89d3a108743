// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/group_statistics.h"

#include "stfLib/base/random.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace stf;

namespace {

// A signal of rms 2 and, in every group, white noise of a standard deviation.
std::vector<std::vector<float>> groups(int count, std::size_t n, float deviation, std::uint64_t seed) {
    std::vector<std::vector<float>> out;
    for (int g = 0; g < count; ++g) {
        CounterRng rng(seed, std::uint64_t(g));
        std::vector<float> values;
        for (std::size_t i = 0; i < n; ++i) {
            const float uniform = std::sqrt(12.0f) * (rng.uniform() - 0.5f); // deviation 1
            values.push_back((i % 2 ? 2.0f : -2.0f) + deviation * uniform);
        }
        out.push_back(values);
    }
    return out;
}

TEST(GroupStatistics, CommonSquareIsFreeOfNoise) {
    for (const int count : {2, 4, 8}) {
        const auto g = groups(count, 40000, 3, 1);
        // Of the mean of pairs of independent products: below 0.05.
        EXPECT_NEAR(commonSquare(g), 4, 0.2) << count;
        EXPECT_NEAR(noiseSquare(g), 9.0 / count, 0.2 * 9 / count) << count;
    }
    EXPECT_NEAR(commonSquare(groups(4, 10000, 0, 1)), 4, 1e-6);
    EXPECT_NEAR(noiseSquare(groups(4, 10000, 0, 1)), 0, 1e-6);
}

// Where there is nothing in common, the mean over seeds is zero: single results have either sign.
TEST(GroupStatistics, CommonSquareIsUnbiased) {
    double sum = 0, squares = 0;
    const int seeds = 200;
    for (int s = 0; s < seeds; ++s) {
        auto g = groups(4, 500, 1, std::uint64_t(s));
        for (auto& values : g) {
            for (std::size_t i = 0; i < values.size(); ++i) {
                values[i] -= i % 2 ? 2.0f : -2.0f;
            }
        }
        const double c = commonSquare(g);
        sum += c;
        squares += c * c;
    }
    const double sigma = std::sqrt(squares / seeds) / std::sqrt(double(seeds));
    EXPECT_LT(std::abs(sum / seeds), 4 * sigma);
    EXPECT_LT(sigma, 0.01);
}

TEST(GroupStatistics, EmptyGroups) {
    EXPECT_EQ(commonSquare({{}, {}}), 0);
    EXPECT_EQ(noiseSquare({{}, {}}), 0);
}

} // namespace
