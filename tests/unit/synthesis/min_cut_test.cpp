// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/min_cut.h"

#include "stfLib/base/random.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

using namespace stf;

TEST(MinCut, IsTheCheapestOfAllDivisions) {
    constexpr int nodes = 9;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        CounterRng rng(seed, 5);
        MinCut cut(nodes);
        float terminal[nodes], pair[nodes][nodes] = {};
        for (int a = 0; a < nodes; ++a) {
            terminal[a] = rng.uniform() - 0.5f;
            cut.addTerminal(std::size_t(a), terminal[a]);
            for (int b = 0; b < nodes; ++b) {
                if (a != b && rng.uniform() < 0.4f) {
                    pair[a][b] = 0.4f * rng.uniform();
                    cut.addPair(std::size_t(a), std::size_t(b), pair[a][b]);
                }
            }
        }
        const auto cost = [&](const auto& onSink) {
            double sum = 0;
            for (int a = 0; a < nodes; ++a) {
                sum += onSink(a) ? double(terminal[a]) : 0.0;
                for (int b = 0; b < nodes; ++b) {
                    sum += !onSink(a) && onSink(b) ? double(pair[a][b]) : 0.0;
                }
            }
            return sum;
        };
        double least = 1e9;
        for (int mask = 0; mask < 1 << nodes; ++mask) {
            least = std::min(least, cost([&](int n) { return (mask >> n & 1) != 0; }));
        }
        cut.solve();
        EXPECT_NEAR(cost([&](int n) { return cut.onSink(std::size_t(n)); }), least, 1e-5) << seed;
    }
}
