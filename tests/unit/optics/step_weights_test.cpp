// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/step_weights.h"

#include <gtest/gtest.h>
#include <limits>

using namespace stf;

namespace {

TEST(StepWeights, AgreeWithLongDouble) {
    for (double exponent = -12; exponent <= 6; exponent += 0.003) {
        const float x = float(std::pow(10, exponent));
        const long double wide = static_cast<long double>(x);
        const long double t = std::exp(-wide), phi1 = -std::expm1(-wide) / wide;
        const StepWeights w = stepWeights(x);
        EXPECT_NEAR(double(w.phi1 / phi1), 1, 2e-7) << x;
        if (x < 87) { // below, float has no normal numbers
            EXPECT_NEAR(double(w.transmittance / t), 1, 2e-7) << x;
        } else {
            EXPECT_NEAR(double(w.transmittance), double(t), 1e-38) << x;
        }
    }
}

TEST(StepWeights, FallMonotonically) {
    StepWeights last = stepWeights(0.0f);
    for (double exponent = -12; exponent <= 6; exponent += 0.001) {
        const StepWeights w = stepWeights(float(std::pow(10, exponent)));
        // One rounding of slack.
        EXPECT_LE(w.transmittance, last.transmittance * (1 + 1.2e-7f));
        EXPECT_LE(w.phi1, last.phi1 * (1 + 1.2e-7f));
        EXPECT_GE(w.transmittance, 0);
        EXPECT_GT(w.phi1, 0);
        last = w;
    }
}

TEST(StepWeights, Ends) {
    EXPECT_EQ(stepWeights(0.0f).transmittance, 1);
    EXPECT_EQ(stepWeights(0.0f).phi1, 1);
    const StepWeights tiny = stepWeights(std::numeric_limits<float>::denorm_min());
    EXPECT_EQ(tiny.transmittance, 1);
    EXPECT_EQ(tiny.phi1, 1);
    for (float x : {1e30f, std::numeric_limits<float>::max(), std::numeric_limits<float>::infinity()}) {
        EXPECT_EQ(stepWeights(x).transmittance, 0);
        EXPECT_LE(stepWeights(x).phi1, 1e-30f);
        EXPECT_GE(stepWeights(x).phi1, 0);
    }
}

TEST(StepWeights, HalvingTheStepChangesNothing) {
    // Two half steps of a constant source add up to one.
    for (float x : {1e-6f, 1e-2f, 0.4f, 0.9f, 5.0f, 60.0f}) {
        const StepWeights whole = stepWeights(x), half = stepWeights(0.5f * x);
        EXPECT_NEAR(half.transmittance * half.transmittance / whole.transmittance, 1, 1e-6f) << x;
        EXPECT_NEAR(0.5f * half.phi1 * (1 + half.transmittance) / whole.phi1, 1, 1e-6f) << x;
    }
}

TEST(StepWeights, ChannelsAreIndependent) {
    for (const Rgb& x : {Rgb(0.3f), Rgb(0.0f, 2.0f, 1e6f), Rgb(0.3f, 0.3f, 0.4f)}) {
        const StepWeightsRgb w = stepWeights(x);
        for (int c = 0; c < 3; ++c) {
            EXPECT_EQ(w.transmittance[c], stepWeights(x[c]).transmittance);
            EXPECT_EQ(w.phi1[c], stepWeights(x[c]).phi1);
        }
    }
}

} // namespace
