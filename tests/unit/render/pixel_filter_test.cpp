// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/error.h"
#include "stfLib/render/pixel_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace stf::test {
namespace {

constexpr PixelFilter::Shape kShapes[] = {PixelFilter::Shape::Box, PixelFilter::Shape::Triangle,
                                          PixelFilter::Shape::Gaussian, PixelFilter::Shape::BlackmanHarris};

// By Simpson's rule.
double integral(const PixelFilter& f, double low, double high, int power) {
    constexpr int kParts = 2000;
    const double h = (high - low) / kParts;
    double sum = 0;
    for (int i = 0; i <= kParts; ++i) {
        // The ends of a box belong to it.
        const double x = low + h * i, inside = std::clamp(x, low + 1e-7, high - 1e-7);
        sum += (i == 0 || i == kParts ? 1 : i % 2 ? 4 : 2) * double(f.value(float(inside))) * std::pow(x, power);
    }
    return sum * h / 3;
}

TEST(PixelFilter, IntegralIsOneAndNothingLiesOutside) {
    for (PixelFilter::Shape shape : kShapes) {
        for (float width : {0.0f, 0.7f, 4.0f}) {
            const PixelFilter f(shape, width);
            const double half = double(f.width()) / 2;
            EXPECT_NEAR(integral(f, -half, half, 0), 1, 2e-5) << int(shape);
            EXPECT_EQ(f.value(float(half) * 1.001f), 0.0f);
            EXPECT_GE(f.offset(0), -half);
            EXPECT_LE(f.offset(1), half);
        }
    }
}

// Offsets at evenly spread numbers have the density that `value` gives: quantile by quantile, and in their variance.
TEST(PixelFilter, OffsetsFollowTheFilter) {
    for (PixelFilter::Shape shape : kShapes) {
        const PixelFilter f(shape);
        const double half = double(f.width()) / 2;
        for (int i = 1; i < 20; ++i) {
            const float u = float(i) / 20;
            EXPECT_NEAR(integral(f, -half, double(f.offset(u)), 0), double(u), 1e-4) << int(shape) << " at " << u;
        }
        constexpr int kCount = 100000;
        double sum = 0, squares = 0;
        float last = -10;
        for (int i = 0; i < kCount; ++i) {
            const float x = f.offset((float(i) + 0.5f) / kCount);
            EXPECT_GE(x, last);
            last = x;
            sum += double(x);
            squares += double(x) * double(x);
        }
        EXPECT_NEAR(sum / kCount, 0, 1e-4);
        EXPECT_NEAR(squares / kCount, integral(f, -half, half, 2), 1e-4) << int(shape);
    }
}

// Variances known in closed form: a box of 1 (1/12), a triangle of 2 (1/6), a Gaussian cut at three deviations.
TEST(PixelFilter, VariancesInClosedForm) {
    const double cutGaussian = 0.25 * (1 - 2 * 3 * std::exp(-4.5) / std::sqrt(2 * M_PI) / std::erf(3 / std::sqrt(2)));
    const std::pair<PixelFilter::Shape, double> known[] = {{PixelFilter::Shape::Box, 1.0 / 12},
                                                           {PixelFilter::Shape::Triangle, 1.0 / 6},
                                                           {PixelFilter::Shape::Gaussian, cutGaussian}};
    for (const auto& [shape, variance] : known) {
        const PixelFilter f(shape);
        EXPECT_NEAR(integral(f, -double(f.width()) / 2, double(f.width()) / 2, 2), variance, 1e-5) << int(shape);
    }
}

TEST(PixelFilter, NamesAndWidths) {
    PixelFilter::Shape shape = PixelFilter::Shape::Box;
    for (const char* name : {"box", "triangle", "gaussian", "blackmanHarris"}) {
        EXPECT_TRUE(PixelFilter::shapeFromName(name, shape)) << name;
    }
    EXPECT_EQ(shape, PixelFilter::Shape::BlackmanHarris);
    EXPECT_FALSE(PixelFilter::shapeFromName("mitchell", shape));
    EXPECT_THROW(PixelFilter(shape, -1), Error);
    EXPECT_THROW(PixelFilter(shape, std::numeric_limits<float>::infinity()), Error);
}

} // namespace
} // namespace stf::test
