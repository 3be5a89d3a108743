// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/direction_set.h"

#include <gtest/gtest.h>
#include <map>

using namespace stf;

namespace {

constexpr float kPi = 3.14159265358979f;

Vec3f at(float theta, float phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

float sum(const DirectionWeights& w) {
    float s = 0;
    for (int i = 0; i < w.count; ++i) {
        EXPECT_GE(w.weight[i], 0);
        s += w.weight[i];
    }
    return s;
}

TEST(DirectionSet, NodesGetTheirOwnWeight) {
    for (int azimuths : {1, 6}) {
        const DirectionSet set(7, azimuths);
        EXPECT_EQ(set.count(), 7 * azimuths);
        for (int i = 0; i < set.count(); ++i) {
            EXPECT_NEAR(length(set.direction(i)), 1, 1e-6f);
            EXPECT_NEAR(set.direction(i).z, std::cos(set.polarAngle(i)), 1e-6f);
            EXPECT_GT(set.direction(i).z, 0.05f) << "below 90 degrees";
            const DirectionWeights w = set.weights(set.direction(i));
            float own = 0;
            for (int k = 0; k < w.count; ++k) {
                // The nodes of the pole are one direction.
                own += w.index[k] == i || (i < azimuths && w.index[k] < azimuths) ? w.weight[k] : 0;
            }
            EXPECT_NEAR(own, 1, 2e-5f) << i;
        }
    }
}

TEST(DirectionSet, WeightsSumToOneUpToTheLastNodeAndFallToZeroAtTheHorizon) {
    for (int polars : {1, 2, 7}) {
        for (int azimuths : {1, 4, 6}) {
            const DirectionSet set(polars, azimuths);
            const float step = 0.5f * kPi / float(polars), last = 0.5f * kPi - step;
            for (float phi = -4; phi < 7; phi += 0.37f) {
                for (float theta = 0; theta < 0.5f * kPi; theta += 0.011f) {
                    const float expected = theta <= last ? 1 : (0.5f * kPi - theta) / step;
                    EXPECT_NEAR(sum(set.weights(at(theta, phi))), expected, 1e-5f) << theta << ", " << phi;
                }
            }
        }
    }
}

TEST(DirectionSet, ReproducesWhatIsLinearInAngle) {
    // Between nodes, the weighted polar angle is the angle.
    const DirectionSet set(7, 6);
    for (float theta = 0.01f; theta < set.polarAngle(set.count() - 1); theta += 0.013f) {
        const DirectionWeights w = set.weights(at(theta, 1.0f));
        float mean = 0;
        for (int k = 0; k < w.count; ++k) {
            mean += w.weight[k] * set.polarAngle(w.index[k]);
        }
        EXPECT_NEAR(mean, theta, 1e-5f);
    }
}

TEST(DirectionSet, AzimuthIsPeriodicAndContinuous) {
    const DirectionSet set(7, 6);
    std::map<int, float> last;
    for (int i = 0; i <= 720; ++i) {
        const DirectionWeights w = set.weights(at(0.5f, kPi * float(i) / 360));
        std::map<int, float> now;
        for (int k = 0; k < w.count; ++k) {
            ASSERT_GE(w.index[k], 0);
            ASSERT_LT(w.index[k], set.count());
            now[w.index[k]] += w.weight[k];
        }
        for (int k = 0; i > 0 && k < set.count(); ++k) {
            ASSERT_NEAR(now[k], last[k], 0.01f) << "at " << 0.5 * i << " degrees"; // 0.5 of 60 degrees
        }
        last = now;
    }
}

TEST(DirectionSet, NoLightFromBelowOrFromNowhere) {
    const DirectionSet set(7, 6);
    EXPECT_EQ(set.weights({1, 0, 0}).count, 0);
    EXPECT_EQ(set.weights({0, 0, -1}).count, 0);
    EXPECT_EQ(set.weights(normalize(Vec3f(1, 1, -1e-6f))).count, 0);
    EXPECT_EQ(set.weights({0, 0, std::nanf("")}).count, 0);
    EXPECT_LT(sum(set.weights(normalize(Vec3f(1, 0, 1e-6f)))), 1e-5f);
}

TEST(DirectionSet, AtLeastOneDirection) {
    const DirectionSet set(0, -2);
    EXPECT_EQ(set.count(), 1);
    EXPECT_EQ(set.direction(0), Vec3f(0, 0, 1));
}

} // namespace
