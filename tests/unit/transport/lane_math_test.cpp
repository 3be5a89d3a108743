// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/lane_math.h"

#include "stfLib/base/random.h"
#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/phase.h"

#include <Random123/threefry.h>
#include <gtest/gtest.h>

using namespace stf;

namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;

TEST(LaneMath, DrawsTheBlocksOfRandom123) {
    CounterRng rng(1, 2);
    for (int i = 0; i < 1000; ++i) {
        const std::uint32_t c0 = rng.bits(), c1 = rng.bits(), k0 = rng.bits(), k1 = rng.bits(), k2 = rng.bits(),
                            k3 = rng.bits();
        const auto expected = r123::Threefry4x32_R<12>()({{c0, c1, 0, 0}}, {{k0, k1, k2, k3}});
        const lane::Block block = lane::threefry(c0, c1, k0, k1, k2, k3);
        for (std::size_t k = 0; k < 4; ++k) {
            ASSERT_EQ(block.r[k], expected[k]);
        }
    }
}

void expectExponential(std::uint32_t bits) {
    const double expected = -std::log((double(bits) + 0.5) * 0x1p-32);
    // Where the argument is near 1, double's logarithm itself loses digits of the distance.
    const double exact = bits > 0x80000000u ? -std::log1p(-(double(~bits) + 0.5) * 0x1p-32) : expected;
    ASSERT_NEAR(double(lane::exponential(bits)), exact, 3e-7 * exact) << bits;
}

TEST(LaneMath, FreeFlightsKeepTheirDigitsAtBothEnds) {
    for (std::uint32_t i = 0; i < 3000; ++i) {
        expectExponential(i);
        expectExponential(~i);
        expectExponential(0xB504F334u - 1500 + i); // where the branch changes
    }
    for (int power = 0; power < 32; ++power) {
        expectExponential(1u << power);
        expectExponential((1u << power) - 1);
    }
    CounterRng rng(5, 0);
    for (int i = 0; i < 200000; ++i) {
        expectExponential(rng.bits());
    }
    EXPECT_GT(lane::exponential(0xffffffffu), 0);
    EXPECT_GT(lane::exponential(0u), 22);
}

TEST(LaneMath, CosineAndSineOfATurn) {
    for (int i = 0; i < 100000; ++i) {
        const float u = float(i) * 1e-5f;
        ASSERT_NEAR(double(lane::cosine(u)), std::cos(kTurn * double(u)), 3e-7) << u;
        ASSERT_NEAR(double(lane::sine(u)), std::sin(kTurn * double(u)), 3e-7) << u;
    }
}

TEST(LaneMath, AnglesAreThoseOfThePhaseFunction) {
    for (float g : {0.0f, 1e-6f, -1e-6f, 0.5f, -0.5f, 0.9f, -0.9f, 0.999f, -0.999f}) {
        for (int i = 0; i < 1000; ++i) {
            const float u = float(i) * 1e-3f;
            const lane::Angle a = lane::scatterAngle(g, u);
            const Vec3f d = sampleHenyeyGreenstein(g, {0, 0, 1}, u, 0.0f);
            ASSERT_NEAR(a.cos, d.z, 2e-6f) << g << " " << u;
            ASSERT_NEAR(a.cos * a.cos + a.sin * a.sin, 1, 4e-6f);
        }
    }
}

TEST(LaneMath, FresnelIsThatOfOptics) {
    for (double eta : {0.4, 0.7, 0.9999, 1.0001, 1.3, 1.5, 2.5}) {
        for (int i = 1; i <= 1000; ++i) {
            const double c = i * 1e-3;
            const lane::Split s = lane::fresnel(c, eta);
            const auto expected = fresnelSplit<double>(c, eta);
            ASSERT_NEAR(s.reflectance, expected.reflectance, 1e-14 + 1e-12 * expected.reflectance) << eta << " " << c;
            ASSERT_NEAR(s.cosT, expected.cosT, 1e-14) << eta << " " << c;
        }
    }
}

} // namespace
