// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/phase.h"

#include "stfLib/base/random.h"
#include "tests/unit/support/statistics.h"

using namespace stf;
using namespace stf::test;

namespace {

constexpr double kPi = 3.14159265358979323846;

class HenyeyGreenstein : public testing::TestWithParam<float> {};

INSTANTIATE_TEST_SUITE_P(MeanCosines, HenyeyGreenstein,
                         testing::Values(0.0f, 1e-8f, -1e-8f, 0.5f, -0.5f, 0.9f, -0.9f, 0.999f, -0.999f),
                         [](const auto& which) { return "Case" + std::to_string(which.index); });

TEST_P(HenyeyGreenstein, IntegratesToOneWithMeanCosineG) {
    const float g = GetParam();
    const int n = 20000;
    double total = 0, mean = 0, second = 0;
    for (int i = 0; i < n; ++i) {
        // theta = pi t^4 from the peak: fine where the function is narrow.
        const double t = (i + 0.5) / n, fromPeak = kPi * t * t * t * t, step = 4 * kPi * t * t * t / n;
        const double c = g < 0 ? -std::cos(fromPeak) : std::cos(fromPeak), s = std::sin(fromPeak);
        const double weight = double(henyeyGreenstein(g, {0, 0, 1}, {float(s), 0, float(c)})) * 2 * kPi * s * step;
        total += weight, mean += weight * c, second += weight * c * c;
    }
    EXPECT_NEAR(total, 1, 2e-6);
    EXPECT_NEAR(mean, double(g), 2e-6);
    EXPECT_NEAR(second, (1 + 2 * double(g) * double(g)) / 3, 2e-6);
}

TEST_P(HenyeyGreenstein, SamplesHaveItsMoments) {
    // Around a skew direction; the first moment of the azimuth must vanish.
    const float g = GetParam();
    const Vec3f from = normalize(Vec3f(0.3f, -0.5f, -0.8f));
    Vec3f t, b;
    orthonormalBasis(from, t, b);
    struct Sums {
        double cosine = 0, second = 0, t = 0, b = 0;
    };
    const int n = 1 << 14;
    const auto batches = runBatches(64, [&](int batch) {
        CounterRng rng(11, std::uint64_t(batch));
        Sums s;
        for (int i = 0; i < n; ++i) {
            const Vec3f w = sampleHenyeyGreenstein(g, from, rng.uniform(), rng.uniform());
            EXPECT_NEAR(length(w), 1, 1e-6f);
            const double c = double(dot(w, from));
            s.cosine += c / n, s.second += c * c / n, s.t += double(dot(w, t)) / n, s.b += double(dot(w, b)) / n;
        }
        return s;
    });
    const Estimate mean = estimate(batches, [](const Sums& s) { return s.cosine; });
    const Estimate second = estimate(batches, [](const Sums& s) { return s.second; });
    EXPECT_LT(mean.sigma, 1e-3);
    EXPECT_NEAR(mean.mean, double(g), 4 * mean.sigma + 1e-7);
    EXPECT_TRUE(agrees(second, (1 + 2 * double(g) * double(g)) / 3, 0.002, 2e-7));
    for (const Estimate& e :
         {estimate(batches, [](const Sums& s) { return s.t; }), estimate(batches, [](const Sums& s) { return s.b; })}) {
        EXPECT_NEAR(e.mean, 0, 4 * e.sigma + 1e-7);
    }
}

TEST_P(HenyeyGreenstein, SamplesItsDensity) {
    // Share of samples within an angle of the axis, by u1 alone, against the closed form.
    const double g = double(GetParam());
    const int n = 100000;
    for (double c : {-0.99, -0.5, 0.0, 0.7, 0.99}) {
        int inside = 0;
        for (int i = 0; i < n; ++i) {
            const Vec3f w = sampleHenyeyGreenstein(GetParam(), {0, 0, 1}, (float(i) + 0.5f) / n, 0.25f);
            inside += double(w.z) > c;
        }
        // P(cos > c) = (1 - g^2) / (2 g) [1 / (1 - g) - 1 / sqrt(1 + g^2 - 2 g c)], (1 - c) / 2 at g = 0.
        const double expected = std::abs(g) < 1e-4
                                    ? 0.5 * (1 - c)
                                    : (1 - g * g) / (2 * g) * (1 / (1 - g) - 1 / std::sqrt(1 + g * g - 2 * g * c));
        EXPECT_NEAR(double(inside) / n, expected, 3e-5) << c;
    }
}

TEST_P(HenyeyGreenstein, FiniteAtBothEnds) {
    const Vec3f from = normalize(Vec3f(1, 2, 3));
    const float g = GetParam();
    const double peak = (1 - std::abs(double(g))) * (1 + std::abs(double(g)));
    const double forward = peak / (4 * kPi * std::pow(1 - double(g), 3));
    const double backward = peak / (4 * kPi * std::pow(1 + double(g), 3));
    EXPECT_NEAR(double(henyeyGreenstein(g, from, from)) / forward, 1, 1e-4);
    EXPECT_NEAR(double(henyeyGreenstein(g, from, -from)) / backward, 1, 1e-4);
    for (float u1 : {0.0f, 1.0f - 0x1p-24f}) {
        for (float u2 : {0.0f, 1.0f - 0x1p-24f}) {
            EXPECT_NEAR(length(sampleHenyeyGreenstein(g, from, u1, u2)), 1, 1e-6f);
        }
    }
}

TEST(HenyeyGreensteinPrecision, SmallAnglesNearOne) {
    // 1 - cos of the sample against long double, where the naive form has no digits left.
    for (float g : {0.99f, 0.9999f, -0.9999f}) {
        for (double u : {1e-6, 1e-3, 0.1, 0.5, 0.9, 0.999}) {
            const float u1 = float(u);
            const Vec3f axis{0, 0, g > 0 ? 1.0f : -1.0f};
            const Vec3f d = sampleHenyeyGreenstein(g, {0, 0, 1}, u1, 0.125f) - axis;
            const double fromPeak =
                0.5 * (double(d.x) * double(d.x) + double(d.y) * double(d.y) + double(d.z) * double(d.z));
            const long double a = std::abs(static_cast<long double>(g)), v = static_cast<long double>(u1);
            const long double s = (1 - a * a) / (1 - a + 2 * a * v);
            // cos = (1 + a^2 - s^2) / (2 a) runs from -1 at v = 0 to 1; the far end is the peak.
            const long double expected = 1 - (1 + a * a - s * s) / (2 * a);
            EXPECT_NEAR(fromPeak / double(expected), 1, 1e-5) << g << ", " << u;
        }
    }
}

TEST(HenyeyGreensteinPrecision, ValueNearThePeak) {
    for (float g : {0.9f, 0.9999f, -0.9999f}) {
        for (float angle : {1e-6f, 1e-4f, 1e-3f, 0.1f, 2.0f}) {
            const float sign = g > 0 ? 1.0f : -1.0f;
            const Vec3f from{0, 0, 1}, to{std::sin(angle), 0, sign * std::cos(angle)};
            // By the angle that was asked for, in double.
            const double a = std::abs(double(g)), h = std::sin(0.5 * double(angle));
            const double expected = (1 - a) * (1 + a) / (4 * kPi * std::pow((1 - a) * (1 - a) + 4 * a * h * h, 1.5));
            EXPECT_NEAR(double(henyeyGreenstein(g, from, to)) / expected, 1, 1e-5) << g << ", " << angle;
        }
    }
}

TEST(HenyeyGreensteinPrecision, ContinuousAcrossZero) {
    const Vec3f from = normalize(Vec3f(1, 0, 1)), to = normalize(Vec3f(-0.2f, 0.9f, 0.1f));
    EXPECT_NEAR(henyeyGreenstein(1e-7f, from, to), henyeyGreenstein(-1e-7f, from, to), 1e-7f);
    EXPECT_NEAR(henyeyGreenstein(0, from, to), float(1 / (4 * kPi)), 1e-8f);
}

} // namespace
