// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/fresnel.h"
#include "stfLib/transport/direction_set.h"

#include <functional>
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
        s += w.weight[i];
    }
    return s;
}

// All weights by node.
std::map<int, float> byNode(const DirectionSet& set, const Vec3f& direction) {
    const DirectionWeights w = set.weights(direction);
    EXPECT_LE(w.count, 16);
    EXPECT_LE(w.across, w.count);
    std::map<int, float> m;
    for (int i = 0; i < w.count; ++i) {
        EXPECT_GE(w.index[i], 0);
        EXPECT_LT(w.index[i], set.count());
        m[w.index[i]] += w.weight[i];
    }
    return m;
}

using Function = std::function<double(double theta, double phi)>;

// What the weights make of a function that is known at the nodes.
double interpolated(const DirectionSet& set, const Function& f, float theta, float phi) {
    double value = 0;
    for (const auto& [index, weight] : byNode(set, at(theta, phi))) {
        const Vec3f d = set.direction(index);
        value += double(weight) * f(double(set.polarAngle(index)), std::atan2(double(d.y), double(d.x)));
    }
    return value;
}

double worstError(const DirectionSet& set, const Function& f, float from, float to) {
    double worst = 0;
    for (float theta = from; theta < to; theta += 0.0037f) {
        for (float phi = -3; phi < 3.2f; phi += 0.173f) {
            worst = std::max(worst, std::abs(interpolated(set, f, theta, phi) - f(double(theta), double(phi))));
        }
    }
    return worst;
}

TEST(DirectionSet, OneNodeAtThePoleAndRingsBelowNinetyDegrees) {
    for (int polars : {1, 2, 7}) {
        for (int azimuths : {1, 2, 6}) {
            const DirectionSet set(polars, azimuths);
            EXPECT_EQ(set.count(), 1 + (polars - 1) * azimuths);
            EXPECT_EQ(set.direction(0), Vec3f(0, 0, 1));
            EXPECT_EQ(set.ring(0), 0);
            for (int i = 0; i < set.count(); ++i) {
                EXPECT_NEAR(length(set.direction(i)), 1, 1e-6f);
                EXPECT_NEAR(set.direction(i).z, std::cos(set.polarAngle(i)), 1e-6f);
                EXPECT_FLOAT_EQ(set.polarAngle(i), float(set.ring(i)) * 0.5f * kPi / float(polars));
                EXPECT_GT(set.direction(i).z, 0.05f);
                for (int k = 0; k < i; ++k) {
                    EXPECT_GT(length(set.direction(i) - set.direction(k)), 0.1f) << "no direction twice";
                }
            }
        }
    }
}

TEST(DirectionSet, NodesGetTheirOwnWeight) {
    for (int polars : {1, 2, 3, 4, 7}) {
        for (int azimuths : {1, 2, 4, 6}) {
            const DirectionSet set(polars, azimuths);
            for (int i = 0; i < set.count(); ++i) {
                for (const auto& [index, weight] : byNode(set, set.direction(i))) {
                    EXPECT_NEAR(weight, index == i ? 1 : 0, 5e-6f) << polars << ", " << azimuths << ": " << i;
                }
            }
        }
    }
}

TEST(DirectionSet, WeightsSumToOneButForTheShareOfNinetyDegrees) {
    for (int polars : {1, 2, 3, 7}) {
        for (int azimuths : {1, 2, 4, 6}) {
            const DirectionSet set(polars, azimuths);
            const float step = 0.5f * kPi / float(polars);
            for (float phi = -4; phi < 7; phi += 0.37f) {
                for (float theta = 0; theta < 0.5f * kPi; theta += 0.011f) {
                    float expected = 1;
                    const float x = theta / step - float(polars); // from 90 degrees
                    if (polars == 1) {
                        expected = -x;
                    } else if (x > -2 || polars == 2) {
                        expected = 1 - (x + 1) * (x + 2) * (x + 3) / 6; // all but the weight of the last of four nodes
                    }
                    EXPECT_NEAR(sum(set.weights(at(theta, phi))), expected, 1e-5f) << theta << ", " << phi;
                }
            }
        }
    }
}

// A cubic that is zero at 90 degrees, through the pole (even there), with and without azimuth.
TEST(DirectionSet, ReproducesCubicsInThePolarAngle) {
    const double end = 0.5 * double(kPi);
    for (int polars : {3, 4, 7, 12}) {
        for (int azimuths : {1, 2, 6}) {
            const DirectionSet set(polars, azimuths);
            const float first = set.polarAngle(1);
            // Even in theta, that is smooth over the pole.
            EXPECT_LT(worstError(
                          set, [&](double t, double) { return end * end - t * t; }, 0, 0.5f * kPi),
                      1e-5);
            // Any cubic where the pole's other side is not looked at.
            EXPECT_LT(worstError(
                          set, [&](double t, double) { return (end - t) * (1 + t * (2 - 3 * t)); }, first + 1e-3f,
                          0.5f * kPi),
                      3e-5);
        }
    }
    // Under a top that refracts the same of what enters.
    const auto enters = [&](double t, double) {
        return (end * end - t * t) * (1 - double(fresnelReflectance(float(std::cos(t)), 1.5f)));
    };
    EXPECT_LT(worstError(DirectionSet(4, 1, 1.5f), enters, 0, 0.5f * kPi), 1e-5);
    EXPECT_GT(worstError(DirectionSet(4, 1), enters, 0, 0.5f * kPi), 0.02) << "which Fresnel's fall would spoil";
    // Two rings: one cubic through both sides of the pole, zero at 90 degrees.
    EXPECT_LT(worstError(
                  DirectionSet(2, 1), [&](double t, double) { return end * end - t * t; }, 0, 0.5f * kPi),
              1e-5);
    // One node: a straight line.
    EXPECT_LT(worstError(
                  DirectionSet(1, 1), [&](double t, double) { return end - t; }, 0, 0.5f * kPi),
              1e-5);
}

// The other side of the pole is the ring at azimuth + pi: functions that are odd over it are met, too.
TEST(DirectionSet, ReproducesALinearFunctionOverThePole) {
    const DirectionSet set(7, 24);
    const float step = 0.5f * kPi / 7;
    const Function tilted = [](double t, double p) { return 1 + t * std::cos(p - 0.4); };
    // The cubic in azimuth is off by at most (d phi)^4 * 3 / 128 in a cosine.
    EXPECT_LT(worstError(set, tilted, 0, step), double(step) * std::pow(2 * double(kPi) / 24, 4) * 3 / 128 + 1e-5);
}

TEST(DirectionSet, ErrorFallsWithTheFourthPowerOfTheStep) {
    const double end = 0.5 * double(kPi);
    const auto ratio = [&](const Function& f, int polars, int azimuths, int finerPolars, int finerAzimuths, float from,
                           float to) {
        return worstError({polars, azimuths}, f, from, to) / worstError({finerPolars, finerAzimuths}, f, from, to);
    };
    // The polar angle alone: smooth over the pole, zero at 90 degrees.
    const Function slab = [](double t, double) { return std::cos(t) * std::exp(1.5 * std::cos(t)); };
    const double polar = ratio(slab, 8, 1, 16, 1, 0, 0.5f * kPi);
    EXPECT_GT(polar, 12);
    EXPECT_LT(polar, 20);
    // Azimuth alone: a cubic in the polar angle.
    const Function turning = [end](double t, double p) {
        return (end * end - t * t) * (std::cos(p) + std::sin(2 * p));
    };
    const double azimuth = ratio(turning, 8, 12, 8, 24, 0.45f, 1.5f);
    EXPECT_GT(azimuth, 12);
    EXPECT_LT(azimuth, 20);
    // Both, over the pole: a function that is smooth on the sphere.
    const Function smooth = [](double t, double p) {
        const double x = std::sin(t) * std::cos(p), y = std::sin(t) * std::sin(p), z = std::cos(t);
        return z * std::exp(0.8 * x - 0.5 * y) * (1 + 0.3 * x * y);
    };
    const double both = ratio(smooth, 9, 12, 18, 24, 0, 0.5f * kPi);
    EXPECT_GT(both, 11);
    EXPECT_LT(both, 20);
    EXPECT_LT(worstError({18, 24}, smooth, 0, 0.5f * kPi), 5e-4);
}

TEST(DirectionSet, ContinuousOverTheSky) {
    for (int polars : {1, 2, 3, 7}) {
        for (int azimuths : {1, 2, 4, 6}) {
            const DirectionSet set(polars, azimuths);
            const auto step = [&](const Vec3f& a, const Vec3f& b) {
                const std::map<int, float> now = byNode(set, a), next = byNode(set, b);
                for (int k = 0; k < set.count(); ++k) {
                    const float x = now.count(k) ? now.at(k) : 0, y = next.count(k) ? next.at(k) : 0;
                    ASSERT_NEAR(x, y, 0.05f) << a.x << ", " << a.y << ", " << a.z; // slope at most 3 in steps
                }
            };
            for (int i = 0; i < 720; ++i) {
                step(at(0.9f, kPi * float(i) / 360), at(0.9f, kPi * float(i + 1) / 360));
                step(at(0.1f, kPi * float(i) / 360), at(0.1f, kPi * float(i + 1) / 360));
            }
            for (float theta = 0; theta < 0.5f * kPi - 0.003f; theta += 0.002f) {
                step(at(theta, 1), at(theta + 0.002f, 1));
            }
            step(at(0.5f * kPi - 0.003f, 1), {1, 0, 0});
        }
    }
}

TEST(DirectionSet, ThePoleFromAnyAzimuth) {
    for (int azimuths : {1, 2, 6}) {
        const DirectionSet set(7, azimuths);
        const DirectionWeights w = set.weights({0, 0, 1});
        ASSERT_EQ(w.count, 1);
        EXPECT_EQ(w.index[0], 0);
        EXPECT_EQ(w.weight[0], 1);
        for (float phi = -4; phi < 4; phi += 0.1f) {
            for (const auto& [index, weight] : byNode(set, at(1e-4f, phi))) {
                EXPECT_NEAR(weight, index == 0 ? 1 : 0, 1e-3f);
            }
        }
        EXPECT_EQ(set.weights({-0.0f, 0.0f, 1}).count, 1);
        EXPECT_EQ(set.weights({1e-30f, -1e-30f, 1}).index[0], 0);
    }
}

// Entries across the pole are marked: what is odd there, a radial component, is then a cubic as well.
TEST(DirectionSet, MarksWhatLiesAcrossThePole) {
    const DirectionSet set(9, 1);
    for (float theta = 0.001f; theta < 1.2f; theta += 0.01f) {
        const DirectionWeights w = set.weights(at(theta, 2));
        double odd = 0;
        for (int i = 0; i < w.count; ++i) {
            const double t = double(set.polarAngle(w.index[i]));
            odd += double(w.weight[i]) * (t - t * t * t) * (i < w.count - w.across ? 1 : -1);
        }
        const double t = double(theta);
        EXPECT_NEAR(odd, t - t * t * t, 1e-5) << theta;
    }
}

TEST(DirectionSet, NoLightFromBelowOrFromNowhere) {
    for (int polars : {1, 2, 7}) {
        const DirectionSet set(polars, 6);
        EXPECT_EQ(set.weights({1, 0, 0}).count, 0);
        EXPECT_EQ(set.weights({0, 0, -1}).count, 0);
        EXPECT_EQ(set.weights({0, 0, 0}).count, 0);
        EXPECT_EQ(set.weights(normalize(Vec3f(1, 1, -1e-6f))).count, 0);
        EXPECT_EQ(set.weights({0, 0, std::nanf("")}).count, 0);
        EXPECT_EQ(set.weights({std::nanf(""), 0, 1}).count, 0);
        for (const auto& [index, weight] : byNode(set, normalize(Vec3f(1, 0, 1e-6f)))) {
            EXPECT_NEAR(weight, 0, 3e-5f) << index;
        }
    }
    EXPECT_EQ(DirectionSet().weights({0, 0, 1}).count, 0);
    EXPECT_EQ(DirectionSet().count(), 0);
}

TEST(DirectionSet, AtLeastOneDirectionAndAnEvenNumberAround) {
    const DirectionSet set(0, -2);
    EXPECT_EQ(set.count(), 1);
    EXPECT_EQ(set.direction(0), Vec3f(0, 0, 1));
    EXPECT_EQ(DirectionSet(3, 5).azimuths(), 6);
}

} // namespace
