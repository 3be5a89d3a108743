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

TEST(WalkFurnace, ConservativeTileInUniformRadianceHas4PiEverywhere) {
    const BaseVolume v = mixed(1);
    const WalkMedium medium(v);
    const auto top = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 64, 4000, 1);
    const auto bottom = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 64, 4000, 2);
    const double volume = v.voxelMm.x * v.voxelMm.y * v.voxelMm.z, area = v.extentMm().x * v.extentMm().y;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        std::vector<double> fluence;
        for (std::size_t b = 0; b < top.size(); ++b) {
            const double track = top[b].collided[i * 3] + top[b].uncollided[i * 3] + bottom[b].collided[i * 3] +
                                 bottom[b].uncollided[i * 3];
            fluence.push_back(track * kPi * area / (4000 * volume)); // unit radiance brings the flux pi * area
        }
        EXPECT_TRUE(agrees(estimate(fluence), 4 * kPi)) << "voxel " << i;
    }
}

TEST(WalkFurnace, DiffuseTransmissionIsTheSameBothWays) {
    const WalkMedium medium(mixed(0.6f));
    const auto down = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 64, 6000, 1);
    const auto up = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 64, 6000, 2);
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
        walkBatches(WalkMedium(homogeneous(size, {1, 1, 1}, Rgb(1.0f), albedo, 0.3f)), normalLight(), 64, 6000, 1);
    for (int c = 0; c < 3; ++c) {
        const auto alone = walkBatches(WalkMedium(homogeneous(size, {1, 1, 1}, Rgb(1.0f), Rgb(albedo[c]), 0.3f)),
                                       normalLight(), 64, 6000, 2);
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
    const Progress progress;
    const WalkTally coloured = WalkMedium(v).walk(normalLight(), 5, 3, 0, 5000, progress);
    EXPECT_FALSE(WalkMedium(v).greyExtinction());
    for (int c = 0; c < 3; ++c) {
        BaseVolume grey = v;
        for (Rgb& k : grey.extinction) {
            k = Rgb(k[c]);
        }
        ASSERT_TRUE(WalkMedium(grey).greyExtinction());
        const WalkTally t = WalkMedium(grey).walk(normalLight(), 5, 3, 0, 5000, progress);
        EXPECT_EQ(t.above[c], coloured.above[c]);
        EXPECT_EQ(t.absorbed[c], coloured.absorbed[c]);
        for (std::size_t i = std::size_t(c); i < t.collided.size(); i += 3) {
            ASSERT_EQ(t.collided[i], coloured.collided[i]);
            ASSERT_EQ(t.uncollided[i], coloured.uncollided[i]);
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
    const Progress progress;
    for (auto kind : {WalkSource::Kind::Direction, WalkSource::Kind::DiffuseTop}) {
        const WalkTally t = WalkMedium(v).walk(diffuse(kind), 1, 0, 0, 20000, progress);
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
    EXPECT_EQ(exp(-WalkMedium(v).opticalDepth({0.5f, 0.5f, 6}, {0, 0, 1})).x, 0);
    EXPECT_EQ(WalkMedium(v).opticalDepth({0.5f, 0.5f, 2}, {0, 0, 1}).x, 0);
}

TEST(WalkLimits, LightPassesVoidsBetweenOpaqueColumnsExactly) {
    BaseVolume v = homogeneous({2, 2, 3}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f));
    for (int z = 0; z < 3; ++z) {
        v.extinction[v.index(0, 0, z)] = v.extinction[v.index(1, 1, z)] = Rgb(1e6f);
    }
    const auto batches = walkBatches(WalkMedium(v), normalLight(), 32, 4000);
    EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& t) { return transmittance(t); }), 0.5));
    for (const WalkTally& t : batches) {
        ASSERT_EQ(t.belowUncollided[0], 0);
        ASSERT_EQ(t.belowUncollided[9], 0);
    }
}

TEST(WalkLimits, OneZeroChannelAndOneStrongOne) {
    const BaseVolume v = homogeneous({1, 1, 4}, {1, 1, 1}, Rgb(0.0f, 1.0f, 1e3f), Rgb(0.9f));
    const Progress progress;
    const WalkTally t = WalkMedium(v).walk(normalLight(), 1, 0, 0, 5000, progress);
    EXPECT_EQ(transmittance(t, 0), 1);
    EXPECT_EQ(transmittance(t, 2), 0);
    EXPECT_GT(reflectance(t, 2), 0.3);
    for (int c = 0; c < 3; ++c) {
        EXPECT_LT(imbalance(t, c), kRounding);
    }
}

TEST(WalkLimits, EmptyTileLetsEverythingThrough) {
    const Progress progress;
    const WalkTally t = WalkMedium(homogeneous({2, 2, 2}, {1, 1, 1}, Rgb(0.0f), Rgb(1.0f)))
                            .walk(normalLight(), 1, 0, 0, 1000, progress);
    EXPECT_EQ(transmittance(t), 1);
    EXPECT_EQ(t.collisions, 0u);
    EXPECT_NEAR(channelSum(t.uncollided, 1), 2000, 1e-6);
}

TEST(WalkLimits, ExtremeMeanCosines) {
    const Progress progress;
    for (float g : {1e-8f, 0.999f, -0.999f, std::nextafter(1.0f, 0.0f), std::nextafter(-1.0f, 0.0f)}) {
        const WalkTally t = WalkMedium(homogeneous({1, 1, 4}, {1, 1, 1}, Rgb(2.0f), Rgb(0.95f), g))
                                .walk(normalLight(), 1, 0, 0, 3000, progress);
        EXPECT_LT(imbalance(t), kRounding) << g;
        EXPECT_EQ(t.lost, 0u);
    }
}

TEST(WalkLimits, ScaleInvariant) {
    // Geometry times s, extinction over s.
    const Progress progress;
    const auto run = [&](float s) {
        return WalkMedium(homogeneous({2, 2, 4}, Vec3d(double(s)), Rgb(1 / s), Rgb(0.9f), 0.5f))
            .walk(normalLight(), 1, 0, 0, 2000, progress);
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
    const Progress progress;
    const WalkMedium medium(mixed(0.5f));
    const WalkTally whole = medium.walk(normalLight(), 1, 0, 0, 1000, progress);
    WalkTally sum = medium.walk(normalLight(), 1, 0, 0, 300, progress);
    sum.add(medium.walk(normalLight(), 1, 0, 300, 700, progress));
    EXPECT_EQ(sum.photons, whole.photons);
    EXPECT_EQ(sum.collisions, whole.collisions);
    EXPECT_NEAR(sum.above.x, whole.above.x, 1e-9);
    EXPECT_NE(medium.walk(normalLight(), 2, 0, 0, 1000, progress).above.x, whole.above.x) << "seed";
    EXPECT_NE(medium.walk(normalLight(), 1, 1, 0, 1000, progress).above.x, whole.above.x) << "source number";
}

TEST(WalkLimits, CancelThrows) {
    Progress progress;
    progress.cancel();
    EXPECT_THROW(WalkMedium(mixed(0.5f)).walk(normalLight(), 1, 0, 0, 1000, progress), Cancelled);
}

} // namespace
