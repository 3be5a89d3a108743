// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/gaussian_mixture.h"
#include "stfLib/acquire/multi_otsu.h"
#include "stfLib/acquire/transfer_function.h"
#include "stfLib/base/error.h"
#include "stfLib/base/random.h"
#include "tests/unit/support/files.h"

#include <cmath>

using namespace stf;
using namespace stf::test;

namespace {

// Values of a mixture by Box and Muller.
std::vector<float> mixture(const std::vector<ValueClass>& classes, std::size_t count, std::uint64_t seed) {
    CounterRng rng(seed, 0);
    std::vector<float> values;
    for (std::size_t i = 0; i < count; ++i) {
        double u = double(rng.uniform());
        std::size_t c = 0;
        while (c + 1 < classes.size() && u >= classes[c].share) {
            u -= classes[c++].share;
        }
        const double z =
            std::sqrt(-2 * std::log(double(rng.uniformPositive()))) * std::cos(2 * M_PI * double(rng.uniform()));
        values.push_back(float(classes[c].mean + classes[c].sigma * z));
    }
    return values;
}

TEST(ValueHistogram, CountsWholeNumbersEvenly) {
    std::vector<float> values;
    for (int i = 0; i < 5000; ++i) {
        values.push_back(float(i % 250));
    }
    const ValueHistogram h = histogramOf(values);
    ASSERT_EQ(h.bins(), 250u);
    for (std::size_t b = 0; b < 250; ++b) {
        EXPECT_EQ(h.counts[b], 20);
        EXPECT_NEAR(h.middle(b), double(b), 1e-9);
    }
    EXPECT_EQ(h.total(), 5000);
    EXPECT_THROW(histogramOf({1, 1, 1}), Error);
    EXPECT_THROW(histogramOf({1, NAN, 2}), Error);
}

// The definition, by trying all pairs of thresholds.
TEST(Otsu, AgreesWithTryingAll) {
    const auto values = mixture({{0.5, 10, 3}, {0.3, 25, 4}, {0.2, 60, 6}}, 3000, 5);
    ValueHistogram h = histogramOf(values, 48);
    const auto spread = [&](std::size_t a, std::size_t b) {
        double w = 0, x = 0, s = 0;
        for (std::size_t i = a; i < b; ++i) {
            w += h.counts[i];
            x += h.counts[i] * h.middle(i);
        }
        for (std::size_t i = a; i < b; ++i) {
            s += w > 0 ? h.counts[i] * std::pow(h.middle(i) - x / w, 2) : 0;
        }
        return s;
    };
    double best = 1e300;
    for (std::size_t a = 1; a < 47; ++a) {
        for (std::size_t b = a + 1; b < 48; ++b) {
            best = std::min(best, spread(0, a) + spread(a, b) + spread(b, 48));
        }
    }
    double found = 0;
    for (const ValueClass& c : classesBetween(h, otsuThresholds(h, 3))) {
        found += c.share * h.total() * c.sigma * c.sigma;
    }
    EXPECT_NEAR(found, best, 1e-9 * best);
}

TEST(Otsu, ThresholdLiesInTheMiddleOfAGap) {
    std::vector<float> values(700, 10.0f);
    values.insert(values.end(), 300, 90.0f);
    const ValueHistogram h = histogramOf(values);
    const auto thresholds = otsuThresholds(h, 2);
    EXPECT_NEAR(thresholds[0], 50, 0.51);
    const auto classes = classesBetween(h, thresholds);
    EXPECT_NEAR(classes[0].share, 0.7, 1e-12);
    EXPECT_NEAR(classes[1].mean, 90, 1e-9);
    EXPECT_THROW(otsuThresholds(h, 3), Error);
    EXPECT_THROW(otsuThresholds(h, 1), Error);
}

TEST(Otsu, MediansLeaveSharedVoxelsOut) {
    auto values = mixture({{0.5, 100, 8}, {0.5, 500, 8}}, 40000, 8);
    for (int i = 0; i < 4000; ++i) { // partial volumes of both
        values.push_back(100 + 0.1f * float(i));
    }
    const ValueHistogram h = histogramOf(values);
    const auto classes = medianClasses(h, {300});
    EXPECT_NEAR(classes[0].mean, 100, 1.2);
    EXPECT_NEAR(classes[1].mean, 500, 1.2);
    EXPECT_NEAR(classes[0].sigma, 8, 1.5);
    EXPECT_GT(classesBetween(h, {300})[0].mean, 105);
    const auto mixed = fitGaussianMixture(h, 2); // its own class for them
    EXPECT_NEAR(mixed[0].mean, 100, 0.3);
    EXPECT_NEAR(mixed[1].sigma, 8, 0.3);
    EXPECT_NEAR(mixed[0].share + mixed[1].share, 1, 1e-9);
}

TEST(GaussianMixture, FindsItsParts) {
    // Overlapping classes, which thresholds would cut short.
    const std::vector<ValueClass> truth{{0.5, 100, 20}, {0.3, 180, 15}, {0.2, 300, 40}};
    const auto found = fitGaussianMixture(histogramOf(mixture(truth, 400000, 7)), 3);
    ASSERT_EQ(found.size(), 3u);
    for (int c = 0; c < 3; ++c) {
        const ValueClass &f = found[std::size_t(c)], &t = truth[std::size_t(c)];
        EXPECT_NEAR(f.share, t.share, 0.02);
        EXPECT_NEAR(f.mean, t.mean, 0.2 * t.sigma);
        EXPECT_NEAR(f.sigma, t.sigma, 0.1 * t.sigma);
    }
}

TEST(GaussianMixture, ASpikeOfBackgroundIsOneClass) {
    auto values = mixture({{0.6, 200, 20}, {0.4, 320, 25}}, 50000, 3);
    values.insert(values.end(), 40000, 0.0f);
    const auto found = fitGaussianMixture(histogramOf(values), 3);
    EXPECT_NEAR(found[0].mean, 0, 1);
    EXPECT_NEAR(found[0].share, 4.0 / 9, 0.01);
    EXPECT_NEAR(found[1].mean, 200, 2);
    EXPECT_NEAR(found[2].mean, 320, 2);
}

TEST(TransferFunction, LinearBetweenPoints) {
    const TransferFunction t({{10, {1, 0}}, {20, {0.5, 0.5}}, {20, {0, 1}}});
    double f[2];
    t.evaluate(-5, f);
    EXPECT_EQ(f[0], 1);
    t.evaluate(15, f);
    EXPECT_NEAR(f[0], 0.75, 1e-12);
    EXPECT_NEAR(f[1], 0.25, 1e-12);
    t.evaluate(20, f); // the upper side of a step
    EXPECT_EQ(f[1], 1);
    t.evaluate(1e9, f);
    EXPECT_EQ(f[1], 1);
    using Points = std::vector<TransferFunction::Point>;
    EXPECT_THROW(TransferFunction(Points{}), Error);
    EXPECT_THROW(TransferFunction(Points{{0, {0.5, 0.4}}}), Error);
    EXPECT_THROW(TransferFunction(Points{{0, {1.5, -0.5}}}), Error);
    EXPECT_THROW(TransferFunction(Points{{5, {1, 0}}, {4, {0, 1}}}), Error);
    EXPECT_THROW(TransferFunction(Points{{5, {1, 0}}, {6, {1}}}), Error);
}

TEST(TransferFunction, Ramps) {
    const TransferFunction t = rampsAt({100, 200}, {20, 0});
    double f[3];
    t.evaluate(95, f);
    EXPECT_NEAR(f[0], 0.75, 1e-12);
    EXPECT_NEAR(f[1], 0.25, 1e-12);
    t.evaluate(150, f);
    EXPECT_EQ(f[1], 1);
    t.evaluate(200.001, f);
    EXPECT_EQ(f[2], 1);
    EXPECT_NE(messageOf<Error>([] { rampsAt({100, 110}, {30}); }).find("overlap"), std::string::npos);
    EXPECT_THROW(rampsAt({100, 90}, {}), Error);
    EXPECT_THROW(rampsAt({100}, {-1}), Error);
    EXPECT_THROW(rampsAt({100, 200, 300}, {1, 2}), Error);

    // Two deviations are pure; the partial volume halfway between is half of each.
    const TransferFunction between = rampsBetween(std::vector<ValueClass>{{0.5, 0, 10}, {0.5, 100, 10}});
    between.evaluate(20, f);
    EXPECT_EQ(f[0], 1);
    between.evaluate(50, f);
    EXPECT_NEAR(f[0], 0.5, 1e-12);
    between.evaluate(80, f);
    EXPECT_NEAR(f[1], 1, 1e-12);
}

} // namespace
