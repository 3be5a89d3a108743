// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/round_series.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

// x = M x + 1 with a diagonal M: the fixed point is 1 / (1 - m).
struct Rounds {
    std::array<double, 3> m, x{};
    int leaps = 0;

    double distance() const {
        double difference = 0, all = 0;
        for (std::size_t i = 0; i < m.size(); ++i) {
            difference += std::abs(x[i] - 1 / (1 - m[i]));
            all += 1 / (1 - m[i]);
        }
        return difference / all;
    }

    int run(double enough, bool leaping) {
        RoundSeries series(enough);
        while (series.rounds() < 10000 && (series.rounds() == 0 || !series.settled())) {
            std::array<double, 3> next = x;
            double change = 0, all = 0;
            for (std::size_t i = 0; i < m.size(); ++i) {
                next[i] = m[i] * x[i] + 1;
                change += std::abs(next[i] - x[i]);
                all += next[i];
            }
            series.add(change / all);
            const double leap = leaping ? series.leap() : 0;
            leaps += leap > 0;
            for (std::size_t i = 0; i < m.size(); ++i) {
                x[i] = next[i] + (next[i] - x[i]) * leap;
            }
        }
        return series.rounds();
    }
};

TEST(RoundSeries, EndsAsNearAsWanted) {
    for (const double largest : {0.05, 0.5, 0.8, 0.95}) {
        for (const bool leaping : {false, true}) {
            Rounds r{{largest, 0.5 * largest, 0.1}};
            r.run(0.005, leaping);
            EXPECT_LT(r.distance(), 0.005 * 1.2) << largest << " " << leaping;
        }
    }
}

TEST(RoundSeries, LeapsSaveRounds) {
    Rounds plain{{0.8, 0.4, 0.1}}, leaping{{0.8, 0.4, 0.1}};
    const int all = plain.run(0.005, false), fewer = leaping.run(0.005, true);
    EXPECT_GE(leaping.leaps, 1);
    EXPECT_LE(2 * fewer, all);
}

TEST(RoundSeries, NothingThatChangesIsSettledAtOnce) {
    RoundSeries series(0.005);
    series.add(0);
    EXPECT_TRUE(series.settled());
    EXPECT_EQ(series.leap(), 0);
}

} // namespace
} // namespace stf::test
