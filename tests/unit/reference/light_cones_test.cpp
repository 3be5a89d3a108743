// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/random.h"
#include "stfLib/reference/light_cones.h"

#include <gtest/gtest.h>

namespace stf {
namespace {

constexpr double kPi = 3.14159265358979323846;

LightCones twoLights() {
    LightCones cones;
    cones.add(normalize(Vec3f(0.3f, 0.1f, 0.8f)), {0, 0, 1}, 1.5f, 0.99f);
    cones.add(normalize(Vec3f(-0.8f, 0.2f, 0.3f)), {0, 0, 1}, 1.5f, 0.9999f);
    return cones;
}

// Directions are chosen with the density that is told: the mean of 1 / density over them is the solid angle of the
// cones' union, which counting uniform directions gives as well.
TEST(LightCones, SamplesHaveTheirDensity) {
    const LightCones cones = twoLights();
    CounterRng rng(1, 2);
    const int n = 200000;
    double sum = 0, squares = 0;
    int covered = 0;
    for (int i = 0; i < n; ++i) {
        const float pick = rng.uniform(), u1 = rng.uniform(), u2 = rng.uniform();
        const float density = cones.density(cones.sample(pick, u1, u2));
        ASSERT_GT(density, 0);
        sum += 1 / double(density);
        squares += 1 / double(density) / double(density);
        const float z = 2 * rng.uniform() - 1, r = std::sqrt(1 - z * z), phi = float(2 * kPi) * rng.uniform();
        covered += cones.density({r * std::cos(phi), r * std::sin(phi), z}) > 0 ? 1 : 0;
    }
    const double mean = sum / n, share = double(covered) / n, solid = 4 * kPi * share;
    const double error = std::sqrt((squares / n - mean * mean) / n + 16 * kPi * kPi * share * (1 - share) / n);
    EXPECT_NEAR(mean, solid, 4 * error);
    EXPECT_LT(error, 0.02 * solid);
}

// The middle of a cone is where Snell's law bends light to; lights below the surface are none.
TEST(LightCones, FollowsSnell) {
    LightCones cones;
    cones.add(normalize(Vec3f(0.3f, 0, -0.8f)), {0, 0, 1}, 1.5f, 1);
    EXPECT_TRUE(cones.empty());
    cones.add({0.6f, 0, 0.8f}, {0, 0, 1}, 1.5f, 1);
    const Vec3f inside{0.4f, 0, std::sqrt(1 - 0.16f)};
    EXPECT_LT(length(cones.sample(0, 0, 0) - inside), 1e-6f);
}

} // namespace
} // namespace stf
