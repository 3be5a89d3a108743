// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

// Everything differs from voxel to voxel, voids included; albedo as given.
BaseVolume mixed(float lowestAlbedo, std::uint64_t seed = 7) {
    BaseVolume v = homogeneous({3, 2, 4}, {0.6, 0.9, 0.5}, Rgb(1.0f), Rgb(1.0f), 0.5f);
    CounterRng rng(seed, 0);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.extinction[i] = Rgb(i % 5 == 3 ? 0.0f : 4 * rng.uniform());
        v.albedo[i] = Rgb(lowestAlbedo + (1 - lowestAlbedo) * rng.uniform());
        v.g[i] = 1.6f * rng.uniform() - 0.8f;
    }
    return v;
}

TEST(WalkFurnace, ConservativeTileInUniformRadianceHas4PiAndNoFlux) {
    const BaseVolume v = mixed(1);
    for (TransportForm form : {TransportForm::Classic, TransportForm::DE1}) {
        const TileMedium medium(v, form);
        WalkRequest request = fluenceRequest();
        request.flux = true;
        const auto top = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 64, 3000, request);
        request.seed = 2;
        const auto bottom = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 64, 3000, request);
        const double volume = v.voxelMm.x * v.voxelMm.y * v.voxelMm.z, area = v.extentMm().x * v.extentMm().y;
        for (std::size_t i = 0; i < v.voxelCount(); ++i) {
            std::vector<std::vector<double>> values(4);
            for (std::size_t b = 0; b < top.size(); ++b) {
                for (std::size_t k = 0; k < 4; ++k) {
                    const std::size_t at = i * 12 + k;
                    const double track =
                        top[b].collided[at] + top[b].uncollided[at] + bottom[b].collided[at] + bottom[b].uncollided[at];
                    values[k].push_back(track * kPi * area /
                                        (3000 * volume)); // unit radiance brings the flux pi * area
                }
            }
            EXPECT_TRUE(agrees(estimate(values[0]), 4 * kPi)) << "voxel " << i;
            for (std::size_t k = 1; k < 4; ++k) {
                const Estimate e = estimate(values[k]);
                EXPECT_LT(e.sigma, 0.01 * 4 * kPi);
                EXPECT_LE(std::abs(e.mean), 4.5 * e.sigma) << "voxel " << i << ", axis " << k;
            }
        }
    }
}

TEST(WalkFurnace, DiffuseTransmissionIsTheSameBothWays) {
    const TileMedium medium = trueMedium(mixed(0.6f));
    const auto down = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 64, 6000);
    const auto up = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 64, 6000, fluenceRequest(0, 2));
    std::vector<double> difference, t;
    for (std::size_t b = 0; b < down.size(); ++b) {
        t.push_back(transmittance(down[b]));
        difference.push_back(t.back() - reflectance(up[b])); // up: `above` is what came through
    }
    const Estimate d = estimate(difference);
    EXPECT_LT(d.sigma, 0.01 * estimate(t).mean);
    EXPECT_LE(std::abs(d.mean), 4 * d.sigma);
}

TEST(WalkChannels, GreyChannelsAreEqualAndColouredAlbedoIsUnbiased) {
    // One walk carries rgb: each channel must come out as if walked alone.
    const Vec3i size(1, 1, 4);
    const Rgb albedo(0.3f, 0.9f, 0.99f);
    const auto together =
        walkBatches(trueMedium(homogeneous(size, {1, 1, 1}, Rgb(1.0f), albedo, 0.3f)), normalLight(), 64, 6000);
    for (int c = 0; c < 3; ++c) {
        const auto alone = walkBatches(trueMedium(homogeneous(size, {1, 1, 1}, Rgb(1.0f), Rgb(albedo[c]), 0.3f)),
                                       normalLight(), 64, 6000, fluenceRequest(0, 2));
        const Estimate a = estimate(together, [&](const WalkTally& t) { return reflectance(t, c); });
        const Estimate b = estimate(alone, [&](const WalkTally& t) { return reflectance(t, 0); });
        EXPECT_LT(std::hypot(a.sigma, b.sigma), 0.015 * b.mean);
        EXPECT_LE(std::abs(a.mean - b.mean), 4 * std::hypot(a.sigma, b.sigma)) << c;
        for (const WalkTally& t : alone) {
            ASSERT_EQ(reflectance(t, 0), reflectance(t, 2));
        }
    }
}

TEST(WalkChannels, ColouredExtinctionIsThreeGreyRuns) {
    BaseVolume v = mixed(0.5f);
    CounterRng rng(1, 1);
    for (Rgb& k : v.extinction) {
        k = k * Rgb(rng.uniform(), 1, 0.2f); // no channel like another
    }
    v.ior.assign(v.voxelCount(), 1.4f);
    WalkRequest request = fluenceRequest(5000, 5);
    request.source = 3;
    request.flux = true;
    for (TransportForm form : {TransportForm::Classic, TransportForm::DE1}) {
        const TileMedium medium(v, form, true);
        const WalkTally coloured = walkOnce(medium, normalLight(), request);
        EXPECT_FALSE(medium.greyExtinction());
        for (int c = 0; c < 3; ++c) {
            BaseVolume grey = v;
            for (Rgb& k : grey.extinction) {
                k = Rgb(k[c]);
            }
            const TileMedium alone(grey, form, true);
            ASSERT_TRUE(alone.greyExtinction());
            const WalkTally t = walkOnce(alone, normalLight(), request);
            EXPECT_EQ(t.above[c], coloured.above[c]);
            EXPECT_EQ(t.absorbed[c], coloured.absorbed[c]);
            EXPECT_EQ(t.belowSquared[c], coloured.belowSquared[c]);
            for (std::size_t i = 0; i < t.collided.size(); ++i) {
                if (int(i / 4 % 3) == c) {
                    ASSERT_EQ(t.collided[i], coloured.collided[i]);
                    ASSERT_EQ(t.uncollided[i], coloured.uncollided[i]);
                }
            }
        }
    }
}

TEST(WalkLimits, NothingPassesAnOpaqueLayerNextToVoids) {
    BaseVolume v = homogeneous({2, 2, 6}, {1, 1, 1}, Rgb(0.0f), Rgb(0.5f));
    for (int y = 0; y < 2; ++y) {
        for (int x = 0; x < 2; ++x) {
            v.extinction[v.index(x, y, 2)] = Rgb(1e6f);
            v.extinction[v.index(x, y, 4)] = Rgb(2.0f);
        }
    }
    const TileMedium medium = trueMedium(v);
    for (auto kind : {WalkSource::Kind::Direction, WalkSource::Kind::DiffuseTop}) {
        const WalkTally t = walkOnce(medium, diffuse(kind), 20000);
        EXPECT_EQ(channelSum(t.below, 0) + channelSum(t.belowUncollided, 0), 0);
        for (std::size_t i = v.index(0, 0, 3) * 3; i < t.uncollided.size(); ++i) {
            ASSERT_EQ(t.uncollided[i], 0);
            ASSERT_EQ(t.collided[i], 0);
        }
        for (double l : t.collided) {
            ASSERT_TRUE(std::isfinite(l) && l >= 0);
        }
        EXPECT_LT(imbalance(t), kRounding);
        EXPECT_GT(t.above.x, 0.1 * 20000) << "half-white, it reflects";
    }
    EXPECT_EQ(exp(-medium.opticalDepth({0.5f, 0.5f, 6}, {0, 0, 1})).x, 0);
    EXPECT_EQ(medium.opticalDepth({0.5f, 0.5f, 2}, {0, 0, 1}).x, 0);
}

TEST(WalkLimits, LightPassesVoidsBetweenOpaqueColumnsExactly) {
    BaseVolume v = homogeneous({2, 2, 3}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f));
    for (int z = 0; z < 3; ++z) {
        v.extinction[v.index(0, 0, z)] = v.extinction[v.index(1, 1, z)] = Rgb(1e6f);
    }
    const auto batches = walkBatches(trueMedium(v), normalLight(), 32, 4000);
    EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& t) { return transmittance(t); }), 0.5));
    for (const WalkTally& t : batches) {
        ASSERT_EQ(t.belowUncollided[0], 0);
        ASSERT_EQ(t.belowUncollided[9], 0);
    }
}

TEST(WalkLimits, OneZeroChannelAndOneStrongOne) {
    const BaseVolume v = homogeneous({1, 1, 4}, {1, 1, 1}, Rgb(0.0f, 1.0f, 1e3f), Rgb(0.9f));
    const WalkTally t = walkOnce(trueMedium(v), normalLight(), 5000);
    EXPECT_EQ(transmittance(t, 0), 1);
    EXPECT_EQ(transmittance(t, 2), 0);
    EXPECT_GT(reflectance(t, 2), 0.3);
    for (int c = 0; c < 3; ++c) {
        EXPECT_LT(imbalance(t, c), kRounding);
    }
}

TEST(WalkLimits, EmptyTileLetsEverythingThrough) {
    const TileMedium medium = trueMedium(homogeneous({2, 2, 2}, {1, 1, 1}, Rgb(0.0f), Rgb(1.0f)));
    EXPECT_FALSE(medium.scatters());
    const WalkTally t = walkOnce(medium, normalLight(), 1000);
    EXPECT_EQ(transmittance(t), 1);
    EXPECT_EQ(t.collisions, 0u);
    EXPECT_NEAR(channelSum(t.uncollided, 1), 2000, 1e-6);
}

TEST(WalkLimits, ThinnestSlabsScatterWhatTheyShould) {
    // To first order in tau: half of what collides is thrown back, R = tau / 2 (n = 1, isotropic, normal light).
    const double tau = 1e-3;
    const auto batches = walkBatches(trueMedium(homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(float(tau)), Rgb(1.0f))),
                                     normalLight(), 64, 25000, totalsRequest());
    EXPECT_TRUE(
        agrees(estimate(batches, [](const WalkTally& t) { return reflectance(t); }), tau / 2, 0.05, tau * tau * 4));
}

// Whatever is thrown at it: finite, balanced and no negative light.
TEST(WalkLimits, StressedMediaStayFiniteAndBalanced) {
    struct Stress {
        const char* name;
        BaseVolume volume;
        std::uint64_t photons = 1000;
    };
    std::vector<Stress> all;
    for (float tau : {1e-12f, 1e-6f, 1e-3f, 1e3f, 1e6f}) {
        for (float albedo : {0.0f, 0.5f, 0.99f}) {
            all.push_back({"optical depth", homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(tau), Rgb(albedo), 0.3f)});
        }
    }
    all.push_back({"conservative, deep", homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(300.0f), Rgb(1.0f))});
    all.push_back({"nearly conservative", homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(300.0f), Rgb(1 - 1e-7f))});
    all.push_back({"opaque and almost white", homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(1e6f), Rgb(0.9999f)), 200});
    for (float g : {1e-8f, 0.999f, -0.999f, std::nextafter(1.0f, 0.0f), std::nextafter(-1.0f, 0.0f)}) {
        all.push_back({"mean cosine", homogeneous({1, 1, 4}, {1, 1, 1}, Rgb(2.0f), Rgb(0.95f), g)});
    }
    {
        // Voids, a black column beside a white one, neighbours of which one is 1e9 times as dense.
        BaseVolume v = homogeneous({4, 1, 3}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f));
        for (int z = 0; z < 3; ++z) {
            v.extinction[v.index(1, 0, z)] = v.extinction[v.index(2, 0, z)] = Rgb(3.0f);
            v.albedo[v.index(2, 0, z)] = Rgb(1.0f);
            v.extinction[v.index(3, 0, z)] = Rgb(z % 2 ? 1e6f : 1e-3f);
            v.albedo[v.index(3, 0, z)] = Rgb(0.9f);
        }
        all.push_back({"columns", v});
    }
    all.push_back({"coloured", homogeneous({1, 1, 2}, {1, 1, 1}, Rgb(0.0f, 1.0f, 1e3f), Rgb(0.0f, 0.5f, 0.9f))});
    all.push_back({"coarse in x, fine in z", homogeneous({1, 1, 3}, {1000, 1, 1e-3}, Rgb(1e3f), Rgb(0.9f))});
    all.push_back({"mixed", mixed(0.2f)});

    const auto check = [](const Stress& s, float n, TransportForm form, const WalkSource& source) {
        BaseVolume v = s.volume;
        if (n != 1) {
            v.ior.assign(v.voxelCount(), n);
        }
        SCOPED_TRACE(std::string(s.name) + ", extinction " + std::to_string(v.extinction[0].z) + ", albedo " +
                     std::to_string(v.albedo[0].z) + ", n " + std::to_string(n) + ", " + name(form));
        WalkRequest request = fluenceRequest(s.photons);
        request.flux = true;
        const WalkTally t = walkOnce(TileMedium(v, form, true), source, request);
        for (int c = 0; c < 3; ++c) {
            EXPECT_LT(imbalance(t, c), kRounding);
            EXPECT_GE(minComponent(t.above), 0);
            EXPECT_GE(minComponent(t.absorbed), 0);
            EXPECT_LE(t.absorbed[c], double(t.photons) * (1 + 1e-9) + std::abs(t.roulette[c]));
        }
        for (const auto* values : {&t.collided, &t.uncollided, &t.below, &t.belowUncollided}) {
            for (double x : *values) {
                ASSERT_TRUE(std::isfinite(x));
            }
        }
        for (std::size_t i = 0; i < t.collided.size(); i += 4) {
            ASSERT_GE(t.collided[i], 0);
            const double* f = &t.collided[i];
            ASSERT_LE(std::sqrt(f[1] * f[1] + f[2] * f[2] + f[3] * f[3]), f[0] * (1 + 1e-5)) << "flux above fluence";
        }
        EXPECT_EQ(t.lost, 0u);
    };
    for (const Stress& s : all) {
        for (float n : {1.0f, 1.5f}) {
            for (auto form : {TransportForm::Classic, TransportForm::DE1}) {
                check(s, n, form, normalLight());
                check(s, n, form, obliqueLight(1e-3));
                check(s, n, form, diffuse(WalkSource::Kind::DiffuseTop));
                check(s, n, form, diffuse(WalkSource::Kind::DiffuseBelow));
            }
        }
    }
}

TEST(WalkLimits, GrazingLight) {
    // Per entering photon a half-infinite medium returns more the more the light grazes, up to 1 for albedo 1.
    const TileMedium medium = trueMedium(homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(1e4f), Rgb(0.9f)));
    const TileMedium thin = trueMedium(homogeneous({2, 2, 2}, {1, 1, 1}, Rgb(0.0f), Rgb(0.9f)));
    double last = 0;
    for (double mu : {1.0, 0.1, 1e-3, 1e-6}) {
        const WalkTally t = walkOnce(medium, obliqueLight(mu), 20000);
        EXPECT_GT(reflectance(t), last);
        EXPECT_LT(imbalance(t), kRounding);
        last = reflectance(t);
        // Through a void it goes on for ever; what is given up is counted.
        const WalkTally v = walkOnce(thin, obliqueLight(mu), 10);
        EXPECT_EQ(v.lost, mu < 1e-5 ? 10u : 0u);
        EXPECT_LT(imbalance(v), kRounding);
    }
    EXPECT_NEAR(last, 1 - std::sqrt(0.1), 0.02) << "H(0) = 1";
}

TEST(WalkLimits, ScaleInvariant) {
    // Geometry times s, extinction over s.
    const auto run = [&](float s) {
        return walkOnce(trueMedium(homogeneous({2, 2, 4}, Vec3d(double(s)), Rgb(1 / s), Rgb(0.9f), 0.5f)),
                        normalLight(), 2000);
    };
    const WalkTally one = run(1);
    for (float s : {0x1p-20f, 0x1p20f}) { // powers of two: the same bits
        const WalkTally t = run(s);
        EXPECT_EQ(t.above.x, one.above.x);
        EXPECT_EQ(t.collisions, one.collisions);
        EXPECT_NEAR(t.collided[0] / double(s) / one.collided[0], 1, 1e-12);
    }
}

TEST(WalkLimits, RangesAddUp) {
    const TileMedium medium = trueMedium(mixed(0.5f));
    const WalkTally whole = walkOnce(medium, normalLight(), 1000);
    WalkRequest request = fluenceRequest(300);
    WalkTally sum = walkOnce(medium, normalLight(), request);
    request.first = 300;
    request.count = 700;
    sum.add(walkOnce(medium, normalLight(), request));
    EXPECT_EQ(sum.photons, whole.photons);
    EXPECT_EQ(sum.collisions, whole.collisions);
    EXPECT_NEAR(sum.above.x, whole.above.x, 1e-9);
    EXPECT_NEAR(sum.aboveSquared.x, whole.aboveSquared.x, 1e-9);
    EXPECT_NE(walkOnce(medium, normalLight(), 1000, 2).above.x, whole.above.x) << "seed";
    request = fluenceRequest(1000);
    request.source = 1;
    EXPECT_NE(walkOnce(medium, normalLight(), request).above.x, whole.above.x) << "source number";
}

TEST(WalkLimits, WhatIsTalliedDoesNotChangeTheWalks) {
    const TileMedium medium = trueMedium(mixed(0.5f));
    WalkRequest all = fluenceRequest(500);
    all.flux = true;
    WalkRequest totals = totalsRequest(500);
    totals.scalar = true;
    const WalkTally a = walkOnce(medium, normalLight(), all), b = walkOnce(medium, normalLight(), 500),
                    c = walkOnce(medium, normalLight(), totals);
    EXPECT_EQ(a.above.x, b.above.x);
    EXPECT_EQ(b.above.x, c.above.x);
    EXPECT_TRUE(c.collided.empty());
    EXPECT_EQ(a.collided[4], b.collided[1]);
}

TEST(WalkLimits, CancelThrows) {
    Progress progress;
    progress.cancel();
    EXPECT_THROW(walk(trueMedium(mixed(0.5f)), normalLight(), fluenceRequest(1000), progress), Cancelled);
}

} // namespace
