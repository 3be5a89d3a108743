// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/fresnel.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

using namespace stf;

namespace {

using Wide = long double;

// The textbook form, by the two polarisations (Born & Wolf, Principles of Optics, 1.5.2).
Wide reflectanceByPolarisation(Wide c, Wide eta) {
    const Wide square = eta * eta - 1 + c * c;
    if (square <= 0) {
        return 1;
    }
    const Wide t = std::sqrt(square) / eta;
    const Wide s = (c - eta * t) / (c + eta * t), p = (eta * c - t) / (eta * c + t);
    return (s * s + p * p) / 2;
}

const std::vector<float> kIndices{1 / 2.5f,  0.67f, 1 / 1.5f, 0.9f, 1 / 1.0001f, 1 - 1e-4f,
                                  1 + 1e-4f, 1.1f,  1.3f,     1.5f, 2.0f,        2.5f};

TEST(Fresnel, AgreesWithLongDouble) {
    for (float eta : kIndices) {
        for (int i = 1; i <= 4000; ++i) {
            const float c = float(i) / 4000;
            const Wide expected = reflectanceByPolarisation(c, eta);
            EXPECT_NEAR(double(fresnelReflectance(c, eta) / expected), 1, 1e-6) << c << ", " << eta;
        }
    }
}

TEST(Fresnel, RefractsAsSnellSays) {
    for (float eta : kIndices) {
        for (float c : {1e-3f, 0.1f, 0.5f, 0.77f, 0.9f, 1.0f}) {
            const Wide square = Wide(eta) * eta - 1 + Wide(c) * c;
            const float expected = square > 0 ? float(std::sqrt(square) / eta) : 0.0f;
            EXPECT_NEAR(fresnel(c, eta).cosT, expected, 2e-7f) << c << ", " << eta;
        }
    }
}

TEST(Fresnel, EqualIndicesReflectNothing) {
    for (float c : {0.0f, 1e-38f, 1e-7f, 0.5f, 1.0f}) {
        const FresnelSplit split = fresnel(c, 1.0f);
        EXPECT_EQ(split.reflectance, 0);
        EXPECT_EQ(split.cosT, c);
    }
}

TEST(Fresnel, NormalIncidence) {
    for (float eta : kIndices) {
        const double e = double(eta), r = (e - 1) / (e + 1);
        EXPECT_NEAR(double(fresnelReflectance(1, eta)) / (r * r), 1, 1e-6) << eta;
        EXPECT_EQ(fresnel(1, eta).cosT, 1) << eta;
    }
}

TEST(Fresnel, GrazingLightIsReflected) {
    for (float eta : kIndices) {
        EXPECT_EQ(fresnelReflectance(0, eta), 1) << eta;
        EXPECT_EQ(fresnelReflectance(-1e-7f, eta), 1) << eta; // rounding of a dot product
        const FresnelSplit split = fresnel(1e-7f, eta);
        EXPECT_NEAR(double(split.reflectance), double(reflectanceByPolarisation(1e-7L, eta)), 1e-6) << eta;
        EXPECT_LE(split.reflectance, 1) << eta;
        EXPECT_NEAR(fresnel(0, eta).cosT, split.cosT, 1e-6f) << eta;
    }
    for (float c : {1e-38f, 1e-30f, 1e-20f}) {
        EXPECT_EQ(fresnelReflectance(c, 1.5f), 1);
        EXPECT_EQ(fresnelReflectance(c, 1 / 1.5f), 1);
    }
}

TEST(Fresnel, EdgeOfTotalReflection) {
    for (float eta : {0.4f, 1 / 1.5f, 0.9f, 0.9999f}) {
        const float critical = float(std::sqrt((1 - double(eta)) * (1 + double(eta))));
        float c = critical * (1 - 1e-5f);
        EXPECT_EQ(fresnelReflectance(c, eta), 1);
        EXPECT_EQ(fresnel(c, eta).cosT, 0);
        // The next floats around the edge, where the reflectance falls with infinite slope.
        c = critical;
        for (int i = 0; i < 8; ++i) {
            c = std::nextafter(c, 0.0f);
        }
        float last = 1;
        for (int i = 0; i < 200; ++i, c = std::nextafter(c, 1.0f)) {
            const FresnelSplit split = fresnel(c, eta);
            EXPECT_NEAR(double(split.reflectance / reflectanceByPolarisation(c, eta)), 1, 1e-6) << c << ", " << eta;
            EXPECT_LE(split.reflectance, last + 2e-7f);
            EXPECT_GE(split.cosT, 0);
            last = split.reflectance;
        }
        EXPECT_LT(last, 1);
    }
}

TEST(Fresnel, StaysBetweenZeroAndOne) {
    for (float eta : {1e-3f, 0.3f, 0.999999f, 1.000001f, 3.0f, 1e3f}) {
        for (int i = 0; i <= 10000; ++i) {
            const FresnelSplit split = fresnel(float(i) / 10000 * 1.0000002f, eta);
            ASSERT_TRUE(split.reflectance >= 0 && split.reflectance <= 1) << i << ", " << eta;
            ASSERT_TRUE(split.cosT >= 0 && split.cosT <= 1) << i << ", " << eta;
        }
    }
}

TEST(Fresnel, Reciprocity) {
    for (float eta : kIndices) {
        for (int i = 1; i <= 100; ++i) {
            // In double: the way back must not be charged with the rounding of the way in.
            const auto in = fresnelSplit<double>(i / 100.0, double(eta));
            if (in.reflectance < 1) {
                const auto out = fresnelSplit<double>(in.cosT, 1 / double(eta));
                EXPECT_NEAR(out.reflectance, in.reflectance, 1e-10) << i << ", " << eta;
                EXPECT_NEAR(out.cosT, i / 100.0, 1e-10) << i << ", " << eta;
            }
        }
    }
    for (float c : {0.2f, 0.5f, 0.8f, 1.0f}) {
        const FresnelSplit in = fresnel(c, 1.5f);
        EXPECT_NEAR(fresnelReflectance(in.cosT, 1 / 1.5f), in.reflectance, 2e-6f) << c;
    }
}

TEST(Fresnel, DirectionsObeySnellAndMirror) {
    const Vec3f n = normalize(Vec3f(0.2f, -0.7f, 0.6f));
    Vec3f t, b;
    orthonormalBasis(n, t, b);
    for (float eta : kIndices) {
        for (float sine : {0.0f, 1e-4f, 0.3f, 0.9f, 0.99999f}) {
            const Vec3f d = normalize(t * sine - n * std::sqrt((1 - sine) * (1 + sine)));
            const float c = -dot(d, n);
            const Vec3f mirrored = reflect(d, n);
            EXPECT_NEAR(length(mirrored), 1, 1e-6f);
            EXPECT_NEAR(dot(mirrored, n), c, 1e-6f);
            EXPECT_NEAR(dot(mirrored, t), dot(d, t), 1e-6f);
            const FresnelSplit split = fresnel(c, eta);
            if (split.reflectance < 1) {
                const Vec3f w = refract(d, n, eta, split);
                EXPECT_NEAR(length(w), 1, 1e-6f);
                EXPECT_NEAR(-dot(w, n), split.cosT, 1e-6f) << sine << ", " << eta;
                EXPECT_NEAR(dot(w, t) * eta, dot(d, t), 1e-6f) << sine << ", " << eta;
                EXPECT_NEAR(dot(w, b), 0, 1e-6f);
            }
        }
    }
}

TEST(DiffuseFresnel, AgreesWithTheTable) {
    const std::vector<std::array<double, 3>> table{
        {1.1, .0251574, .1943449},  {1.2, .0442803, .3363057}, {1.3, .0611318, .4444567},
        {1.33, .0659308, .4719491}, {1.4, .0768115, .5289855}, {1.5, .0917780, .5963458},
        {1.6, .1062456, .6508772},  {1.8, .1340544, .7327329}, {2.0, .1605966, .7901492}};
    for (const auto& [n, outside, inside] : table) {
        EXPECT_NEAR(diffuseFresnel(n), outside, 6e-8) << n;
        EXPECT_NEAR(diffuseFresnel(1 / n), inside, 6e-8) << n;
    }
}

TEST(DiffuseFresnel, AgreesWithTheClosedForm) {
    // Walsh 1926, after Duntley 1942 ("The optical properties of diffusing materials"), in long double.
    for (double n : {1.01, 1.3, 1.5, 2.5, 10.0}) {
        const Wide m = n, m2 = m * m, m4 = m2 * m2;
        const Wide expected = 0.5L + (m - 1) * (3 * m + 1) / (6 * (m + 1) * (m + 1)) +
                              m2 * (m2 - 1) * (m2 - 1) / std::pow(m2 + 1, 3.0L) * std::log((m - 1) / (m + 1)) -
                              2 * m * m2 * (m2 + 2 * m - 1) / ((m2 + 1) * (m4 - 1)) +
                              8 * m4 * (m4 + 1) / ((m2 + 1) * (m4 - 1) * (m4 - 1)) * std::log(m);
        EXPECT_NEAR(diffuseFresnel(n) / double(expected), 1, 1e-11) << n;
    }
}

TEST(DiffuseFresnel, IsTheMomentOfTheReflectanceOnBothSides) {
    // Also a check of the identity: the inside is integrated by itself here, its total part apart.
    for (double n : {1 + 1e-4, 1.01, 1.3, 1.5, 2.5}) {
        const int count = 200000;
        double outside = 0, inside = 0;
        const double k = (n - 1) * (n + 1), critical = std::sqrt(k) / n;
        for (int i = 0; i < count; ++i) {
            const double t = (i + 0.5) / count;
            // mu = t^2 outside; mu^2 = critical^2 + (1 - critical^2) t^2 inside takes out the root at the edge.
            outside += fresnelSplit<double>(t * t, n).reflectance * 4 * t * t * t / count;
            const double mu = std::sqrt(critical * critical + t * t / (n * n));
            inside += fresnelSplit<double>(mu, 1 / n).reflectance * 2 * t / (n * n) / count;
        }
        EXPECT_NEAR(diffuseFresnel(n) / outside, 1, 1e-7) << n;
        EXPECT_NEAR(diffuseFresnel(1 / n), critical * critical + inside, 1e-9) << n;
        EXPECT_NEAR(diffuseFresnel(1 / n), 1 - (1 - diffuseFresnel(n)) / (n * n), 1e-14) << n;
    }
}

TEST(DiffuseFresnel, Ends) {
    EXPECT_EQ(diffuseFresnel(1), 0);
    // To first order in n - 1: a third of it outside, two more by the identity inside.
    const double n = 1 + 1e-10;
    EXPECT_NEAR(diffuseFresnel(n) / (n - 1), 1.0 / 3, 1e-8);
    EXPECT_NEAR(diffuseFresnel(1 - 1e-10) / 1e-10, 7.0 / 3, 1e-6);
    EXPECT_GT(diffuseFresnel(1e6), 0.99999);
    EXPECT_LE(diffuseFresnel(1e6), 1);
    EXPECT_LE(diffuseFresnel(1e-6), 1);
}

} // namespace
