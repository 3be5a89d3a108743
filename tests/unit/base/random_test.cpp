// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/random.h"

#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <vector>

using namespace stf;

namespace {

TEST(CounterRng, UniformMoments) {
    CounterRng rng(42, 7);
    const int n = 1 << 20;
    double sum[4] = {0, 0, 0, 0}, product = 0, previous = 0.5;
    for (int i = 0; i < n; ++i) {
        const double u = double(rng.uniform());
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
        for (double p = u, *s = sum; s < sum + 4; ++s, p *= u) {
            *s += p;
        }
        product += (u - 0.5) * (previous - 0.5);
        previous = u;
    }
    for (int k = 1; k <= 4; ++k) {
        // Moment 1/(k+1), variance 1/(2k+1) - 1/(k+1)^2; 4 sigma is 0.2 % to 0.5 %.
        const double sigma = std::sqrt((1.0 / (2 * k + 1) - 1.0 / ((k + 1) * (k + 1))) / n);
        EXPECT_NEAR(sum[k - 1] / n, 1.0 / (k + 1), 4 * sigma) << k;
    }
    EXPECT_NEAR(product / n, 0, 4 / (12 * std::sqrt(double(n)))) << "neighbours are correlated";
}

TEST(CounterRng, StreamsAreUniformAcrossNumbers) {
    // The first number of many streams, as photons and pixels use them.
    const int n = 1 << 18;
    double first = 0, second = 0, product = 0;
    for (int i = 0; i < n; ++i) {
        CounterRng rng(3, std::uint64_t(i));
        const double a = double(rng.uniform()), b = double(rng.uniform());
        first += a, second += b, product += (a - 0.5) * (b - 0.5);
    }
    const double sigma = std::sqrt(1.0 / 12 / n);
    EXPECT_NEAR(first / n, 0.5, 4 * sigma);
    EXPECT_NEAR(second / n, 0.5, 4 * sigma);
    EXPECT_NEAR(product / n, 0, 4 / (12 * std::sqrt(double(n))));
}

TEST(CounterRng, DoesNotDependOnOrder) {
    std::vector<std::uint32_t> forward(64), interleaved(64);
    for (std::uint64_t s = 0; s < 8; ++s) {
        CounterRng rng(9, s);
        for (std::size_t i = 0; i < 8; ++i) {
            forward[s * 8 + i] = rng.bits();
        }
    }
    std::vector<CounterRng> streams;
    for (std::uint64_t s = 0; s < 8; ++s) {
        streams.emplace_back(9, s);
    }
    for (std::size_t i = 0; i < 8; ++i) {
        for (std::size_t s = 8; s-- > 0;) {
            interleaved[s * 8 + i] = streams[s].bits();
        }
    }
    EXPECT_EQ(forward, interleaved);
    EXPECT_EQ(std::set<std::uint32_t>(forward.begin(), forward.end()).size(), 64u);
}

TEST(CounterRng, AllBitsOfKeyAndStreamCount) {
    std::set<std::uint32_t> values;
    for (int bit = 0; bit < 64; ++bit) {
        values.insert(hash32(std::uint64_t(1) << bit, 0));
        values.insert(hash32(0, std::uint64_t(1) << bit));
    }
    EXPECT_EQ(values.size(), 128u);
}

TEST(CounterRng, PositiveIsNeverZero) {
    CounterRng a(1, 1), b(1, 1);
    for (int i = 0; i < 100000; ++i) {
        const float u = a.uniform(), p = b.uniformPositive();
        ASSERT_GT(p, 0);
        ASSERT_LE(p, 1);
        ASSERT_FLOAT_EQ(p - 0x1p-24f, u);
    }
}

TEST(CounterRng, ExponentialHasBothTails) {
    const int n = 2000000;
    CounterRng rng(4, 4);
    double sum = 0, squares = 0, below = 0, above = 0;
    for (int i = 0; i < n; ++i) {
        const double x = double(rng.exponential());
        ASSERT_GT(x, 0);
        sum += x, squares += x * x;
        below += x < 1e-4;
        above += x > 9;
    }
    EXPECT_NEAR(sum / n, 1, 4 / std::sqrt(double(n)));
    EXPECT_NEAR(squares / n, 2, 4 * std::sqrt(20.0 / n)); // variance of x^2: 4! - 2^2
    EXPECT_NEAR(below / n, -std::expm1(-1e-4), 4 * std::sqrt(1e-4 / n));
    EXPECT_NEAR(above / n, std::exp(-9), 4 * std::sqrt(std::exp(-9) / n));
}

} // namespace
