// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/fresnel.h"
#include "tests/unit/support/chi_square.h"
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

BaseVolume slab(double tau, double albedo, double g, double n) {
    return withIndex(homogeneous({2, 1, 4}, {0.7, 0.4, 0.25}, Rgb(float(tau)), Rgb(float(albedo)), float(g)), n);
}

// Conservative, every voxel another, some void.
BaseVolume mixedWhite(double n) {
    BaseVolume v = homogeneous({2, 2, 3}, {0.6, 0.9, 0.5}, Rgb(1.0f), Rgb(1.0f), 0.5f);
    CounterRng rng(3, 0);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.extinction[i] = Rgb(i % 5 == 3 ? 0.0f : 4 * rng.uniform());
        v.g[i] = 1.6f * rng.uniform() - 0.8f;
    }
    return withIndex(v, n);
}

// Fluence is 4 pi n^2 and flux nothing, from unit radiance outside of both faces; where the bottom is matched, n^2
// comes from there.
void expectFurnace(double n, bool openBottom, std::uint64_t seed) {
    SCOPED_TRACE("n " + std::to_string(n) + (openBottom ? ", open" : ", matched") + " bottom");
    const BaseVolume v = mixedWhite(n);
    const TileMedium medium = trueMedium(v, openBottom);
    WalkRequest request = fluenceRequest(0, seed);
    request.flux = true;
    const std::uint64_t photons = 2500;
    const auto top = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 64, photons, request);
    request.seed = seed + 1;
    const auto bottom = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 64, photons, request);
    const double volume = v.voxelMm.x * v.voxelMm.y * v.voxelMm.z, area = v.extentMm().x * v.extentMm().y;
    const double scale = kPi * area / (double(photons) * volume), below = openBottom ? 1 : n * n;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        for (std::size_t k = 0; k < 4; ++k) {
            std::vector<double> values;
            for (std::size_t b = 0; b < top.size(); ++b) {
                const std::size_t at = i * 12 + k;
                values.push_back(scale * (top[b].collided[at] + top[b].uncollided[at] +
                                          below * (bottom[b].collided[at] + bottom[b].uncollided[at])));
            }
            const Estimate e = estimate(values);
            const double expected = k == 0 ? 4 * kPi * n * n : 0;
            EXPECT_LT(e.sigma, 0.012 * 4 * kPi * n * n);
            EXPECT_LE(std::abs(e.mean - expected), 4.5 * e.sigma) << "voxel " << i << ", component " << k;
        }
    }
    for (std::size_t b = 0; b < top.size(); ++b) {
        ASSERT_LT(imbalance(top[b]), kRounding);
        ASSERT_LT(imbalance(bottom[b]), kRounding);
    }
}

TEST(WalkRefraction, FurnaceOfBothSides) {
    expectFurnace(1.3, true, 1);
    expectFurnace(1.5, true, 3);
    expectFurnace(0.8, true, 5);
    expectFurnace(1.4, false, 7);
}

// Black slab, light at a cosine: the geometric series of both faces.
TEST(WalkRefraction, BlackSlabIsTheSeriesOfItsFaces) {
    ChiSquare chi;
    std::uint64_t seed = 10;
    for (double n : {1.0001, 1.33, 2.5}) {
        for (double mu : {1.0, 0.5, 0.1}) {
            for (bool open : {true, false}) {
                const double tau = 0.4;
                const auto split = fresnelSplit<double>(mu, n);
                const double f = split.reflectance, e = std::exp(-tau / split.cosT);
                const double r = open ? f + (1 - f) * (1 - f) * f * e * e / (1 - f * f * e * e) : f;
                const double t = open ? (1 - f) * (1 - f) * e / (1 - f * f * e * e) : (1 - f) * e;
                const auto batches = walkBatches(trueMedium(slab(tau, 0, 0, n), open), obliqueLight(mu), 64, 2000,
                                                 totalsRequest(0, ++seed));
                SCOPED_TRACE("n " + std::to_string(n) + ", mu " + std::to_string(mu));
                std::vector<std::vector<double>> values(2);
                for (const WalkTally& b : batches) {
                    values[0].push_back(reflectance(b));
                    values[1].push_back(transmittance(b));
                    ASSERT_NEAR(b.specular.x / double(b.photons), f, 1e-6) << "by weight, without noise";
                    ASSERT_EQ(channelSum(b.below, 0), 0);
                    ASSERT_NEAR(channelSum(b.belowUncollidedCosine, 0) / channelSum(b.belowUncollided, 0), split.cosT,
                                1e-5);
                }
                EXPECT_TRUE(agrees(estimate(values[1]), t, 0.03));
                EXPECT_NEAR(estimate(values[0]).mean, r, 4 * estimate(values[0]).sigma + 1e-6);
                chi.add({values[1]}, {t});
            }
        }
    }
    EXPECT_TRUE(chi.holds("black slabs"));
}

TEST(WalkRefraction, IndexNearOneIsNearlyNone) {
    const double tau = 2, albedo = 0.9, g = 0.3;
    const auto run = [&](double n) {
        return walkBatches(trueMedium(slab(tau, albedo, g, n), true), diffuse(WalkSource::Kind::DiffuseTop), 64, 3000,
                           totalsRequest());
    };
    const auto none = run(1), near = run(1.0001), nearer = run(1 + 1e-6);
    for (const auto* some : {&near, &nearer}) {
        std::vector<double> r, t;
        for (std::size_t b = 0; b < none.size(); ++b) {
            r.push_back(reflectance((*some)[b]) - reflectance(none[b]));
            t.push_back(transmittance((*some)[b]) - transmittance(none[b]));
            ASSERT_TRUE(std::isfinite(r.back()) && std::isfinite(t.back()));
        }
        // Diffuse light of index 1.0001 is reflected by 5e-5 from outside and 2.5e-4 from inside.
        EXPECT_NEAR(estimate(r).mean, 0, 4 * estimate(r).sigma + 4e-4);
        EXPECT_NEAR(estimate(t).mean, 0, 4 * estimate(t).sigma + 4e-4);
        EXPECT_LT(estimate(r).sigma, 2e-3);
    }
}

// Diffuse light from a matched bottom through a void: what the top reflects back, partly in total.
TEST(WalkRefraction, TotalReflectionAtTheTop) {
    for (double n : {1.1, 1.5, 2.5}) {
        const TileMedium medium = trueMedium(slab(0, 0, 0, n));
        const auto batches =
            walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 64, 4000, totalsRequest(0, 4));
        EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& b) { return reflectance(b); }),
                           1 - diffuseFresnel(1 / n), 0.02));
        for (const WalkTally& b : batches) {
            ASSERT_LT(imbalance(b), kRounding);
        }
    }
    // The same from outside: what enters, leaves at once through the matched bottom.
    const auto batches = walkBatches(trueMedium(slab(0, 0, 0, 1.5)), diffuse(WalkSource::Kind::DiffuseTop), 64, 4000,
                                     totalsRequest(0, 5));
    EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& b) { return reflectance(b); }), diffuseFresnel(1.5)));
}

TEST(WalkRefraction, HighIndexKeepsMostOfItsLight) {
    // Conservative and deep: what comes out is what went in; the part that went in is 1 - F at every angle.
    for (double mu : {1.0, 0.2}) {
        const WalkTally t = walkOnce(trueMedium(slab(40, 1, 0.5, 2.5), true), obliqueLight(mu), totalsRequest(2000));
        EXPECT_LT(imbalance(t), kRounding);
        EXPECT_NEAR(t.specular.x / 2000, double(fresnelReflectance(float(mu), 2.5f)), 1e-6);
        EXPECT_EQ(t.absorbed.x, 0);
    }
}

// Every grazing angle, from both sides, in both kinds of walk.
TEST(WalkRefraction, GrazingLight) {
    for (double mu : {1e-2, 1e-4, 1e-7}) {
        for (double n : {0.7, 1.0001, 1.5}) {
            for (bool analog : {false, true}) {
                WalkRequest request = fluenceRequest(2000);
                request.analog = analog;
                const WalkTally t = walkOnce(trueMedium(slab(1, 0.9, 0.5, n), true), obliqueLight(mu), request);
                EXPECT_LT(imbalance(t), kRounding);
                EXPECT_NEAR(t.specular.x / 2000, double(fresnelReflectance(float(mu), float(n))), analog ? 0.05 : 1e-6);
                for (double x : t.collided) {
                    ASSERT_TRUE(std::isfinite(x));
                }
            }
        }
    }
}

// Each column has the index of its own top.
TEST(WalkRefraction, IndexMayDifferFromColumnToColumn) {
    BaseVolume v = homogeneous({2, 1, 2}, {1, 1, 1}, Rgb(0.5f), Rgb(0.0f));
    v.ior = {1.0f, 1.6f, 1.0f, 1.6f};
    const double f = double(fresnelReflectance(1, 1.6f));
    const auto batches = walkBatches(trueMedium(v), normalLight(), 64, 4000);
    EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& b) { return reflectance(b); }), f / 2, 0.02));
    for (int x : {0, 1}) {
        const double expected = 0.5 * (x ? 1 - f : 1) * std::exp(-1);
        EXPECT_TRUE(agrees(
            estimate(batches,
                     [&](const WalkTally& b) { return b.belowUncollided[std::size_t(x) * 3] / double(b.photons); }),
            expected, 0.02));
    }
}

// Light that nothing scatters and both faces reflect in total is given up, and counted.
TEST(WalkRefraction, TrappedLightEnds) {
    BaseVolume v = slab(0, 0, 0, 1.5);
    v.emission.assign(v.voxelCount(), Rgb(1.0f));
    const WalkTally t = walkOnce(trueMedium(v, true), diffuse(WalkSource::Kind::Emission), totalsRequest(40));
    EXPECT_GT(t.lost, 15u);
    EXPECT_LT(t.lost, 39u);
    EXPECT_LT(imbalance(t), kRounding);
}

// The light that enters grazing leaves grazing on the other side: no column without light, none with too much.
TEST(WalkRefraction, RefractedLightLandsWhereSnellSays) {
    BaseVolume v = withIndex(homogeneous({8, 1, 2}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f)), 1.5);
    for (int x = 0; x < 4; ++x) {
        v.extinction[v.index(x, 0, 0)] = Rgb(1e6f); // a roof over half of the tile
    }
    const double sine = 1.5 * std::sin(std::atan(0.5)), mu = std::sqrt(1 - sine * sine);
    const auto batches = walkBatches(trueMedium(v), obliqueLight(mu), 16, 10000);
    const double f = double(fresnelReflectance(float(mu), 1.5f));
    const auto share = [](int x) {
        return [x](const WalkTally& b) { return 8 * b.belowUncollided[std::size_t(x) * 3] / double(b.photons); };
    };
    // Refracted it moves half a voxel towards -x per layer, as in WalkSlab.LightEntersWhereItsDirectionSays.
    EXPECT_TRUE(agrees(estimate(batches, share(6)), 1 - f, 0.02));
    EXPECT_TRUE(agrees(estimate(batches, share(3)), 0.5 * (1 - f), 0.02));
    EXPECT_EQ(estimate(batches, share(1)).mean, 0);
    EXPECT_EQ(estimate(batches, share(7)).mean, 0);
}

} // namespace
