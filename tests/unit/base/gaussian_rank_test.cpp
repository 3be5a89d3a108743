// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/gaussian_rank.h"

#include "stfLib/base/random.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

TEST(GaussianRank, QuantilesOfTables) {
    // Abramowitz & Stegun, table 26.5.
    EXPECT_NEAR(normalQuantile(0.975), 1.959963984540054, 1e-12);
    EXPECT_NEAR(normalQuantile(0.0005), -3.290526731491926, 1e-12);
    EXPECT_DOUBLE_EQ(normalQuantile(0.5), 0);
}

TEST(GaussianRank, RanksAreNormalWhateverTheValuesWere) {
    std::vector<float> values;
    CounterRng rng(1, 1);
    for (int i = 0; i < 5000; ++i) {
        const float u = rng.uniform();
        values.push_back(u < 0.3f ? 0.0f : u * u * u); // a third of them are equal
    }
    const std::vector<float> g = gaussianRanks(values);
    double m[5] = {0, 0, 0, 0, 0};
    for (float x : g) {
        for (int k = 1; k < 5; ++k) {
            m[k] += std::pow(double(x), k) / double(g.size());
        }
    }
    EXPECT_NEAR(m[1], 0, 1e-6);
    EXPECT_NEAR(m[2], 1, 2e-3);
    EXPECT_NEAR(m[4], 3, 3e-2);
    for (std::size_t i = 1; i < g.size(); ++i) {
        if (values[i] != values[i - 1]) {
            EXPECT_EQ(g[i] > g[i - 1], values[i] > values[i - 1]);
        }
    }
}

TEST(GaussianRank, QuantilesUndoRanks) {
    std::vector<float> values;
    CounterRng rng(2, 1);
    for (int i = 0; i < 20000; ++i) {
        values.push_back(std::exp(rng.uniform()));
    }
    const std::vector<float> g = gaussianRanks(values), q = gaussianQuantiles(values, 129, 3.5f);
    ASSERT_EQ(q.size(), 129u);
    for (std::size_t i = 0; i < values.size(); i += 37) {
        const float at = std::clamp((g[i] + 3.5f) / 7 * 128, 0.0f, 127.999f);
        const std::size_t k = std::size_t(at);
        EXPECT_NEAR(q[k] + (q[k + 1] - q[k]) * (at - float(k)), values[i], 4e-3); // a step holds some hundred values
    }
    EXPECT_TRUE(gaussianQuantiles({}, 5, 3).empty());
}

} // namespace
} // namespace stf::test
