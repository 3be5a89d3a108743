// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/adaptive_sampling.h"

#include "stfLib/base/random.h"

#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr int kWidth = 48, kHeight = 32;

struct Statistics {
    double mean, scatter;
};

// A picture whose right half scatters ten times as much as its left half; the mean is 1.
Statistics halves(int x) {
    return {1, x < kWidth / 2 ? 0.1 : 1.0};
}

// From the middle on it is 100 times as bright; the first bright column scatters, by little of what is around it.
Statistics brightEdge(int x) {
    return x < kWidth / 2 ? Statistics{0.5, 0.0} : Statistics{50, x == kWidth / 2 ? 20.0 : 0.0};
}

struct Painted {
    Film film;
    AdaptiveSampling adaptive;
    int passes = 0;

    explicit Painted(double target, int most, std::uint64_t seed = 1, Statistics (*statistics)(int x) = halves) {
        film.resize(kWidth, kHeight);
        adaptive.restart(kWidth, kHeight);
        for (; passes < most && adaptive.activeCount() > 0; ++passes) {
            adaptive.beforePass(film, std::uint32_t(passes), target);
            for (int y = 0; y < kHeight; ++y) {
                for (int x = 0; x < kWidth; ++x) {
                    if (adaptive.active(x, y)) {
                        CounterRng rng(seed, (std::uint64_t(y) * kWidth + std::uint64_t(x)) * 100000 +
                                                 film.sampleCount(x, y));
                        // Uniform, of that standard deviation.
                        PixelSample s;
                        const Statistics of = statistics(x);
                        s.color = Rgb(float(of.mean + of.scatter * std::sqrt(12.0) * (double(rng.uniform()) - 0.5)));
                        film.add(x, y, s);
                    }
                }
            }
        }
    }
    double meanSamples(int x0, int x1) const {
        double sum = 0;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = x0; x < x1; ++x) {
                sum += film.sampleCount(x, y);
            }
        }
        return sum / (kHeight * (x1 - x0));
    }
};

TEST(AdaptiveSampling, NoisyPixelsGetMore) {
    const Painted p(0.05, 100000);
    // (scatter / target)^2 samples: 4, less than the first judgement, and 400.
    EXPECT_EQ(p.meanSamples(0, kWidth / 2 - 2), 16);
    const double noisy = p.meanSamples(kWidth / 2 + 2, kWidth);
    EXPECT_GT(noisy, 400);
    EXPECT_LT(noisy, 1.5 * 400 * 1.2); // judged after half as many again
    EXPECT_EQ(p.adaptive.activeCount(), 0u);
}

TEST(AdaptiveSampling, ErrorsAreWhatWasAskedFor) {
    const Painted p(0.05, 100000);
    double squares = 0;
    int n = 0;
    const std::vector<float> color = p.film.read(Aov::Color);
    for (int y = 0; y < kHeight; ++y) {
        for (int x = kWidth / 2 + 2; x < kWidth; ++x, ++n) {
            const double d = double(color[4 * std::size_t(y * kWidth + x)]) - 1;
            squares += d * d;
        }
    }
    EXPECT_LT(std::sqrt(squares / n), 0.05 * 1.05);
    EXPECT_GT(std::sqrt(squares / n), 0.03);
}

TEST(AdaptiveSampling, StoppingShiftsTheMeanByLessThanTheSquareOfTheTarget) {
    double mean = 0, squares = 0;
    constexpr int n = 10;
    for (int i = 0; i < n; ++i) {
        const Painted p(0.2, 100000, std::uint64_t(i + 1)); // 25 samples: judged at 16, 24, 36
        const std::vector<float> color = p.film.read(Aov::Color);
        double sum = 0;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = kWidth / 2; x < kWidth; ++x) {
                sum += double(color[4 * std::size_t(y * kWidth + x)]);
            }
        }
        sum /= kHeight * kWidth / 2;
        mean += sum / n;
        squares += sum * sum / n;
    }
    // Who is bright by chance is let go sooner.
    EXPECT_NEAR(mean, 1, 4 * std::sqrt((squares - mean * mean) / n) + 0.25 * 0.2 * 0.2);
}

TEST(AdaptiveSampling, DarkPixelsDoNotWaitForBrightNeighboursWithoutEnd) {
    // Among bright pixels 20 / sqrt(16) / 3 of 50 is good enough; for the dark ones it takes 20 / sqrt(n) / 3 of 17.
    const Painted p(0.04, 5000, 1, brightEdge);
    EXPECT_EQ(p.adaptive.activeCount(), 0u);
    EXPECT_LT(p.passes, 400);
    EXPECT_GT(p.meanSamples(kWidth / 2, kWidth / 2 + 1), 60);
}

TEST(AdaptiveSampling, WithoutTargetAllGoOn) {
    const Painted p(0, 50);
    EXPECT_EQ(p.passes, 50);
    EXPECT_EQ(p.meanSamples(0, kWidth), 50);
}

TEST(AdaptiveSampling, BlackPixelsAreDone) {
    Film film;
    film.resize(4, 4);
    AdaptiveSampling adaptive;
    adaptive.restart(4, 4);
    for (int i = 0; i < 16; ++i) {
        for (int k = 0; k < 16; ++k) {
            film.add(k % 4, k / 4, PixelSample());
        }
    }
    adaptive.beforePass(film, 16, 0.01);
    EXPECT_EQ(adaptive.activeCount(), 0u);
}

} // namespace
} // namespace stf::test
