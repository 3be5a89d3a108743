// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/exemplar.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/synthesis/similar_texels.h"
#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

Exemplar made(const BaseVolume& v) {
    Progress progress;
    return makeExemplar(v, {}, progress);
}

AppearanceImage noise(int w, int h) {
    AppearanceImage image;
    image.width = w;
    image.height = h;
    CounterRng rng(3, 1);
    image.texels.resize(std::size_t(w * h));
    for (AppearanceImage::Value& v : image.texels) {
        for (float& x : v) {
            x = rng.uniform();
        }
    }
    return image;
}

} // namespace

TEST(Exemplar, DistancesAreThoseOfTheResponseWhereOnlyThatVaries) {
    // Columns differ in absorption alone; all of it in few dimensions.
    const Exemplar e = made(waves(48));
    EXPECT_GT(e.keptVariance, 0.9);
    EXPECT_EQ(e.stack[0].texels.size(), 48u * 48u);
    // Texels that look alike are near each other, others are not: by rank over pairs.
    double near = 0, far = 0;
    int nears = 0, fars = 0;
    for (std::size_t i = 0; i < 48 * 48; i += 7) {
        for (std::size_t j = i + 1; j < 48 * 48; j += 11) {
            const double r = std::abs(std::cbrt(double(e.response[i].x)) - std::cbrt(double(e.response[j].x)));
            const double d = std::sqrt(double(squaredDistance(e.stack[0].texels[i], e.stack[0].texels[j])));
            if (r > 0.12) {
                far += d;
                ++fars;
            } else if (r < 0.01) {
                near += d;
                ++nears;
            }
        }
    }
    ASSERT_GT(nears, 100);
    ASSERT_GT(fars, 100);
    EXPECT_GT(far / fars, 1.5 * near / nears);
}

TEST(Exemplar, SamplingIsBilinearAndPeriodic) {
    const AppearanceImage image = noise(5, 4);
    for (int y = -4; y < 8; ++y) {
        for (int x = -5; x < 10; ++x) {
            const AppearanceImage::Value at = image.sample(float(x) + 0.5f, float(y) + 0.5f);
            EXPECT_LT(squaredDistance(at, image.at(x, y)), 1e-9f);
            const AppearanceImage::Value between = image.sample(float(x) + 1.0f, float(y) + 0.75f);
            for (std::size_t d = 0; d < between.size(); ++d) {
                const float top = 0.5f * (image.at(x, y)[d] + image.at(x + 1, y)[d]),
                            low = 0.5f * (image.at(x, y + 1)[d] + image.at(x + 1, y + 1)[d]);
                EXPECT_NEAR(between[d], 0.75f * top + 0.25f * low, 1e-5f);
            }
        }
    }
}

TEST(Exemplar, StackKeepsTheMeanAndLosesDetail) {
    const Exemplar e = made(waves(48));
    ASSERT_GE(e.stack.size(), 4u);
    double before = 1e30;
    for (const AppearanceImage& level : e.stack) {
        double mean = 0, square = 0;
        for (const AppearanceImage::Value& v : level.texels) {
            mean += double(v[0]);
            square += double(v[0]) * double(v[0]);
        }
        EXPECT_NEAR(mean / double(level.texels.size()), 0, 0.02);
        EXPECT_LT(square, before);
        before = square;
    }
}

TEST(Exemplar, OfAUniformSampleHasNothingToTell) {
    BaseVolume v = waves(8);
    std::fill(v.albedo.begin(), v.albedo.end(), Rgb(0.9f));
    const Exemplar e = made(v);
    for (const AppearanceImage::Value& t : e.stack[0].texels) {
        EXPECT_LT(squaredDistance(t, e.stack[0].texels[0]), 1e-6f);
    }
    EXPECT_TRUE(e.parameters.empty());
}

TEST(Exemplar, ReliefIsAParameter) {
    BaseVolume v = waves(16);
    v.surface.resize(v.voxelCount());
    for (int z = 0; z < 3; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                // Surface at a depth of 0.3 mm to 1 mm.
                v.surface[v.index(x, y, z)] = float(0.65 + 0.35 * std::cos(2 * pi * x / 16) - (z + 0.5) * 0.5);
            }
        }
    }
    const Exemplar e = made(v);
    ASSERT_NE(std::find(e.parameterNames.begin(), e.parameterNames.end(), "height"), e.parameterNames.end());
    const std::size_t p =
        std::size_t(std::find(e.parameterNames.begin(), e.parameterNames.end(), "height") - e.parameterNames.begin());
    for (int x = 0; x < 16; ++x) {
        EXPECT_NEAR(e.parameters[p][std::size_t(x)], -(0.65 + 0.35 * std::cos(2 * pi * x / 16)), 1e-5);
    }
}

TEST(Exemplar, DoesNotDependOnThreads) {
    setThreadCount(1);
    const Exemplar one = made(waves(32));
    setThreadCount(4);
    const Exemplar four = made(waves(32));
    setThreadCount(0);
    EXPECT_EQ(one.stack[0].texels, four.stack[0].texels);
    EXPECT_EQ(one.similar, four.similar);
}

TEST(Exemplar, RefusesAResponseOfAnotherSize) {
    Progress progress;
    EXPECT_THROW(makeExemplar(waves(8), std::vector<Rgb>(3), progress), Error);
}

TEST(SimilarTexels, AreTheNearestThatKeepTheirDistance) {
    const AppearanceImage image = noise(24, 20);
    const int k = 3, spacing = 4;
    const std::vector<int> similar = similarTexels(image, k);
    const auto apart = [](int a, int b, int n) { return std::min(std::abs(a - b), n - std::abs(a - b)); };
    const auto near = [&](int a, int b) {
        return apart(a % 24, b % 24, 24) < spacing && apart(a / 24, b / 24, 20) < spacing;
    };
    for (int t = 0; t < 24 * 20; ++t) {
        // By going through all texels.
        std::vector<std::pair<float, int>> order;
        for (int i = 0; i < 24 * 20; ++i) {
            order.push_back({squaredDistance(image.texels[std::size_t(t)], image.texels[std::size_t(i)]), i});
        }
        std::sort(order.begin(), order.end());
        std::vector<int> expected;
        for (const auto& [d, i] : order) {
            if (int(expected.size()) < k && !near(i, t) &&
                std::none_of(expected.begin(), expected.end(), [&](int e) { return near(e, i); })) {
                expected.push_back(i);
            }
        }
        for (int i = 0; i < k; ++i) {
            EXPECT_EQ(similar[std::size_t(t * k + i)], expected[std::size_t(i)]);
        }
    }
}

TEST(SimilarTexels, OfATileThatRepeatsItselfHaveNoError) {
    AppearanceImage half = noise(12, 24), image;
    image.width = image.height = 24;
    for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 24; ++x) {
            image.texels.push_back(half.at(x, y));
        }
    }
    EXPECT_NEAR(ownNeighbourhoodError(image, similarTexels(image, 4), 4), 0, 1e-6);
    EXPECT_GT(ownNeighbourhoodError(noise(24, 24), similarTexels(noise(24, 24), 4), 4), 0.1);
}
