// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/sampler.h"

#include <gtest/gtest.h>
#include <vector>

using namespace stf;

namespace {

// Points of one pair of dimensions of the first samples of a pixel.
std::vector<Vec2f> points(std::uint64_t seed, std::uint64_t pixel, int pair, std::uint32_t count) {
    std::vector<Vec2f> p;
    for (std::uint32_t i = 0; i < count; ++i) {
        PixelSampler sampler(seed, pixel, i);
        for (int k = 0; k < pair; ++k) {
            sampler.next2d();
        }
        p.push_back(sampler.next2d());
    }
    return p;
}

// Every elementary box of area 1/n holds exactly one of n points: a (0, m, 2) net in base 2.
void expectStratified(const std::vector<Vec2f>& p, int m) {
    const int n = 1 << m;
    for (int a = 0; a <= m; ++a) {
        std::vector<int> boxes(std::size_t(n), 0);
        for (int i = 0; i < n; ++i) {
            const int x = int(p[std::size_t(i)].x * float(1 << a)), y = int(p[std::size_t(i)].y * float(1 << (m - a)));
            ++boxes[std::size_t(x + (y << a))];
        }
        for (int count : boxes) {
            ASSERT_EQ(count, 1) << "2^" << m << " points, boxes 2^-" << a << " wide";
        }
    }
}

TEST(PixelSampler, EveryPrefixIsStratified) {
    for (std::uint64_t pixel : {0, 1, 12345}) {
        for (int pair = 0; pair < 3; ++pair) {
            const std::vector<Vec2f> p = points(1, pixel, pair, 1 << 10);
            for (int m = 0; m <= 10; ++m) {
                expectStratified(p, m);
            }
        }
    }
}

TEST(PixelSampler, Deterministic) {
    EXPECT_EQ(points(5, 77, 2, 64), points(5, 77, 2, 64));
}

TEST(PixelSampler, PixelsSeedsAndPairsDiffer) {
    const std::vector<Vec2f> p = points(5, 77, 0, 64);
    for (const auto& other : {points(5, 78, 0, 64), points(6, 77, 0, 64), points(5, 77, 1, 64)}) {
        int same = 0;
        for (std::size_t i = 0; i < 64; ++i) {
            same += p[i] == other[i];
        }
        EXPECT_LT(same, 2);
    }
}

TEST(PixelSampler, FirstSamplesOfPixelsAreUniform) {
    const int n = 1 << 16;
    double x = 0, y = 0, xy = 0, xx = 0;
    for (int i = 0; i < n; ++i) {
        const Vec2f u = PixelSampler(2, std::uint64_t(i), 0).next2d();
        ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
        x += double(u.x), y += double(u.y), xx += double(u.x * u.x);
        xy += double((u.x - 0.5f) * (u.y - 0.5f));
    }
    const double root = std::sqrt(double(n));
    EXPECT_NEAR(x / n, 0.5, 4 * std::sqrt(1.0 / 12) / root);
    EXPECT_NEAR(y / n, 0.5, 4 * std::sqrt(1.0 / 12) / root);
    EXPECT_NEAR(xx / n, 1.0 / 3, 4 * std::sqrt(4.0 / 45) / root);
    EXPECT_NEAR(xy / n, 0, 4.0 / 12 / root);
}

TEST(PixelSampler, PairsOfOneSampleAreIndependent) {
    // Over the samples of one pixel and over pixels, dimension 0 tells nothing about dimension 2.
    double sum = 0;
    const int n = 1 << 16;
    for (int i = 0; i < n; ++i) {
        PixelSampler sampler(8, std::uint64_t(i / 64), std::uint32_t(i % 64));
        const float a = sampler.next1d(), b = sampler.next1d();
        sum += double((a - 0.5f) * (b - 0.5f));
    }
    EXPECT_NEAR(sum / n, 0, 4.0 / 12 / std::sqrt(double(n)));
}

} // namespace
