// SPDX-License-Identifier: Apache-2.0
// UsdPreviewSurface's reflection: reciprocity, energy, closed forms, and sampling against its own density.
#include "stfLib/render/preview_bsdf.h"

#include "stfLib/base/random.h"
#include "tests/unit/support/chi_square.h"

#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979;

Vec3f direction(double cosine, double phi) {
    const double s = std::sqrt(1 - cosine * cosine);
    return Vec3f(float(s * std::cos(phi)), float(s * std::sin(phi)), float(cosine));
}

PreviewPoint metal(float roughness) {
    PreviewPoint p;
    p.diffuse = Rgb(0.0f);
    p.f0 = p.f90 = Rgb(1.0f);
    p.roughness = roughness;
    return p;
}

PreviewPoint plastic(float roughness) {
    PreviewPoint p;
    p.diffuse = {0.9f, 0.5f, 0.1f};
    p.f0 = Rgb(0.04f);
    p.f90 = Rgb(1.0f);
    p.roughness = roughness;
    return p;
}

PreviewPoint coated(float roughness) {
    PreviewPoint p = plastic(roughness);
    p.diffuse = Rgb(1.0f);
    p.clearcoat = 1;
    p.clearcoatRoughness = 0.3f;
    return p;
}

// Share of light from `out` that is sent back, by midpoints over the hemisphere.
double albedoByQuadrature(const PreviewBsdf& bsdf, const Vec3f& out, int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double mu = (i + 0.5) / n;
        for (int j = 0; j < 2 * n; ++j) {
            sum += mu * double(bsdf.evaluate(out, direction(mu, (j + 0.5) * kPi / n)).x);
        }
    }
    return sum * (1.0 / n) * (kPi / n);
}

// The same by `sample`, with its standard error.
Estimate albedoBySampling(const PreviewBsdf& bsdf, const Vec3f& out, int perBatch) {
    std::vector<double> batches;
    for (int b = 0; b < 32; ++b) {
        CounterRng rng(3, std::uint64_t(b));
        double sum = 0;
        for (int i = 0; i < perBatch; ++i) {
            const float pick = rng.uniform(), x = rng.uniform(), y = rng.uniform();
            sum += double(bsdf.sample(out, pick, {x, y}).weight.x);
        }
        batches.push_back(sum / perBatch);
    }
    return estimate(batches);
}

TEST(PreviewBsdf, IsReciprocal) {
    CounterRng rng(1, 0);
    for (const PreviewPoint& p : {metal(0.3f), plastic(0.5f), coated(0.2f)}) {
        const PreviewBsdf bsdf(p);
        for (int i = 0; i < 200; ++i) {
            const Vec3f a = direction(0.01 + 0.99 * double(rng.uniform()), 2 * kPi * double(rng.uniform()));
            const Vec3f b = direction(0.01 + 0.99 * double(rng.uniform()), 2 * kPi * double(rng.uniform()));
            const Rgb there = bsdf.evaluate(a, b), back = bsdf.evaluate(b, a);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(there[c], back[c], 1e-4f * there[c]);
            }
        }
    }
}

TEST(PreviewBsdf, NeverSendsBackMoreThanItGets) {
    for (const float roughness : {0.2f, 0.4f, 0.7f, 1.0f}) {
        for (const double mu : {0.05, 0.2, 0.5, 0.8, 1.0}) {
            for (const PreviewPoint& p : {metal(roughness), coated(roughness), plastic(roughness)}) {
                const double albedo = albedoByQuadrature(PreviewBsdf(p), direction(mu, 0.3), 400);
                EXPECT_LE(albedo, 1.002) << roughness << " " << mu;
                EXPECT_GT(albedo, 0.2) << roughness << " " << mu;
            }
        }
    }
}

// At roughness 1 normals are uniform in projected solid angle, and masking is elementary: the lobe is
// 1 / (2 pi (cos i + cos o)), whose integral is 1 - mu ln(1 + 1 / mu).
TEST(PreviewBsdf, WhiteMetalAtRoughnessOneHasItsClosedForm) {
    const PreviewBsdf bsdf(metal(1));
    for (const double mu : {0.1, 0.3, 0.6, 1.0}) {
        const double exact = 1 - mu * std::log(1 + 1 / mu);
        EXPECT_NEAR(albedoByQuadrature(bsdf, direction(mu, 0), 300), exact, 2e-4);
        EXPECT_TRUE(agrees(albedoBySampling(bsdf, direction(mu, 0), 4000), exact));
    }
}

TEST(PreviewBsdf, SmoothWhiteMetalLosesNothing) {
    const PreviewBsdf bsdf(metal(0));
    for (const double mu : {0.1, 0.5, 1.0}) {
        EXPECT_NEAR(albedoBySampling(bsdf, direction(mu, 0), 200).mean, 1, 2e-4);
    }
    const PreviewBsdf::Sample s = bsdf.sample(direction(0.6, 0), 0.5f, {0.3f, 0.3f});
    const Vec3f mirrored = direction(0.6, kPi);
    EXPECT_NEAR(dot(s.in, mirrored), 1, 1e-5);
}

// What the header says of the light that single scattering loses, along the normal.
TEST(PreviewBsdf, StatedLossOfRoughMetals) {
    EXPECT_TRUE(agrees(albedoBySampling(PreviewBsdf(metal(0.5f)), direction(1, 0), 4000), 0.92, 0.01, 0.005));
    EXPECT_TRUE(agrees(albedoBySampling(PreviewBsdf(metal(1)), direction(1, 0), 4000), 1 - std::log(2.0)));
}

TEST(PreviewBsdf, SamplingAgreesWithQuadrature) {
    for (const PreviewPoint& p : {metal(0.5f), plastic(0.6f), coated(0.5f)}) {
        const PreviewBsdf bsdf(p);
        for (const double mu : {0.2, 0.7}) {
            const Vec3f out = direction(mu, 1);
            EXPECT_TRUE(agrees(albedoBySampling(bsdf, out, 8000), albedoByQuadrature(bsdf, out, 500), 0.01, 1e-3))
                << mu;
        }
    }
}

// Directions fall into bins of the hemisphere as the density says.
TEST(PreviewBsdf, DirectionsFollowTheDensity) {
    constexpr int rings = 5, sectors = 6, batches = 40, perBatch = 4000, fine = 60;
    const Vec3f out = direction(0.5, 0.7);
    for (const PreviewPoint& p : {metal(0.6f), plastic(0.6f), coated(0.7f)}) {
        const PreviewBsdf bsdf(p);
        std::vector<double> expected(rings * sectors, 0.0);
        double total = 0;
        for (int i = 0; i < rings * fine; ++i) {
            for (int j = 0; j < sectors * fine; ++j) {
                const Vec3f in = direction((i + 0.5) / (rings * fine), (j + 0.5) * 2 * kPi / (sectors * fine));
                const double share = double(bsdf.density(out, in)) * 2 * kPi / (double(rings * fine) * sectors * fine);
                expected[std::size_t(i / fine * sectors + j / fine)] += share;
                total += share;
            }
        }
        EXPECT_LE(total, 1.001) << "what is missing goes below the horizon";
        std::vector<std::vector<double>> found(expected.size(), std::vector<double>(batches, 0.0));
        for (int b = 0; b < batches; ++b) {
            CounterRng rng(9, std::uint64_t(b));
            for (int i = 0; i < perBatch; ++i) {
                const float pick = rng.uniform(), x = rng.uniform(), y = rng.uniform();
                const Vec3f in = bsdf.sample(out, pick, {x, y}).in;
                if (in.z > 0) {
                    const double phi = std::atan2(double(in.y), double(in.x)) / (2 * kPi);
                    const int ring = std::min(rings - 1, int(in.z * rings));
                    const int sector = std::min(sectors - 1, int((phi < 0 ? phi + 1 : phi) * sectors));
                    found[std::size_t(ring * sectors + sector)][std::size_t(b)] += 1.0 / perBatch;
                }
            }
        }
        ChiSquare chi;
        chi.add(found, expected);
        EXPECT_TRUE(chi.holds("directions"));
    }
}

TEST(PreviewBsdf, WhatIsClearIsNotReflectedAsWell) {
    PreviewPoint p = plastic(0.3f);
    p.opacity = 0;
    const PreviewBsdf bsdf(p);
    EXPECT_NEAR(bsdf.through({0, 0, 1}).x, 0.96f, 1e-6f);
    EXPECT_NEAR(bsdf.through({1, 0, 0}).x, 0.0f, 1e-6f);
    EXPECT_LT(albedoByQuadrature(bsdf, {0, 0, 1}, 300), 0.05) << "no diffuse light of what is not there";
    p.presence = true;
    p.opacity = 0.25f;
    EXPECT_EQ(PreviewBsdf(p).through({0, 0, 1}), Rgb(0.75f));
}

} // namespace
} // namespace stf::test
