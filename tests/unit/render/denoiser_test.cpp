// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/error.h"
#include "stfLib/base/random.h"
#include "stfLib/render/denoiser.h"
#include "stfLib/render/film.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stf::test {
namespace {

TEST(Denoiser, SaysWhyItIsNotThere) {
    std::string why = "untouched";
    const bool available = Denoiser::available(&why);
    EXPECT_EQ(available, why.empty());
    DenoiserInput wrong;
    wrong.width = wrong.height = 2;
    wrong.color.resize(5);
    EXPECT_THROW(Denoiser::denoise(wrong), Error);
}

// Light of two levels with noise of a known size, far above 1: its error against the truth shrinks to less than a
// third, and the mean stays.
TEST(Denoiser, TakesTheNoiseAway) {
    std::string why;
    if (!Denoiser::available(&why)) {
        GTEST_SKIP() << why;
    }
    constexpr int kSize = 128;
    DenoiserInput in;
    in.width = in.height = kSize;
    std::vector<double> truth;
    CounterRng rng(7, 0);
    for (int i = 0; i < kSize * kSize; ++i) {
        const bool right = i % kSize >= kSize / 2;
        truth.push_back(right ? 8.0 : 2.0);
        for (int c = 0; c < 3; ++c) {
            in.color.push_back(
                float(truth.back() * (0.5 + double(rng.uniform())))); // uniform, deviation 0.29 of the mean
            in.albedo.push_back(right ? 0.8f : 0.2f);
            in.normal.push_back(c == 2 ? 1.0f : 0.0f);
        }
    }
    const std::vector<float> out = Denoiser::denoise(in);
    double before = 0, after = 0, mean = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        before += std::pow(double(in.color[3 * i]) - truth[i], 2);
        after += std::pow(double(out[3 * i]) - truth[i], 2);
        mean += double(out[3 * i]) / double(truth.size());
    }
    EXPECT_LT(std::sqrt(after / before), 1.0 / 3);
    EXPECT_NEAR(mean, 5, 0.1);
}

// Until it is there, the film shows what it has; samples to come make it stale.
TEST(Denoiser, TheFilmKeepsItUntilSamplesCome) {
    Film film;
    film.resize(1, 1);
    PixelSample s;
    s.color = Rgb(0.5f);
    s.alpha = 1;
    film.add(0, 0, s);
    EXPECT_EQ(film.read(Aov::Denoised), film.read(Aov::Color));
    film.setDenoised({0.25f, 0.5f, 0.75f});
    EXPECT_EQ(film.read(Aov::Denoised), (std::vector<float>{0.25f, 0.5f, 0.75f, 1}));
    EXPECT_EQ(film.read(Aov::Color), (std::vector<float>{0.5f, 0.5f, 0.5f, 1}));
    film.setDenoised({});
    EXPECT_EQ(film.read(Aov::Denoised), film.read(Aov::Color));
    film.setDenoised({1, 1, 1});
    film.clear();
    EXPECT_EQ(film.read(Aov::Denoised)[0], 0.0f);
}

} // namespace
} // namespace stf::test
