// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/support/files.h"
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

// An anisotropic tile of several columns and layers: homogeneous in all but its voxels.
BaseVolume slab(double tau, double albedo, double g) {
    const Vec3i size(2, 3, 5);
    const Vec3d voxelMm(0.5, 0.8, 0.3);
    return homogeneous(size, voxelMm, Rgb(float(tau / (size.z * voxelMm.z))), Rgb(float(albedo)), float(g));
}

// Photons that bring R and T below 1 % of noise.
std::uint64_t photonsFor(double tau, double r) {
    return tau > 10 ? 3000 : r < 0.01 ? 50000 : 8000;
}

void expectCase(const BaseVolume& v, const WalkSource& source, double r, double t, double unscattered,
                std::uint64_t photons, const std::string& name) {
    SCOPED_TRACE(name);
    const auto batches = walkBatches(WalkMedium(v), source, 64, photons);
    EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& b) { return reflectance(b); }), r));
    EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& b) { return transmittance(b); }), t));
    // What the collisions add, by itself: it is small in thin slabs.
    EXPECT_TRUE(
        agrees(estimate(batches, [](const WalkTally& b) { return transmittance(b) - transmittedUncollided(b); }),
               t - unscattered));
    if (1 - r - t > 1e-3) {
        EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& b) { return absorptance(b); }), 1 - r - t));
    }
    if (unscattered > 0.05) {
        EXPECT_TRUE(
            agrees(estimate(batches, [](const WalkTally& b) { return transmittedUncollided(b); }), unscattered));
    }
    for (const WalkTally& b : batches) {
        for (int c = 0; c < 3; ++c) {
            ASSERT_LT(imbalance(b, c), kRounding);
        }
        ASSERT_EQ(b.lost, 0u);
    }
}

TEST(WalkSlab, ReferenceSlabs) {
    int compared = 0;
    const nlohmann::json data = reference("slab_cases.json");
    for (const auto& c : data["cases"]) {
        const double tau = c["tau"], albedo = c["albedo"], g = c["g"], n = c["n"];
        if (n != 1 || tau > 100) {
            continue;
        }
        const BaseVolume v = slab(tau, albedo, g);
        std::ostringstream name;
        name << "tau " << tau << ", albedo " << albedo << ", g " << g;
        const double r = c["normal"]["R_total"], t = c["normal"]["T_total"];
        expectCase(v, normalLight(), r, t, std::exp(-tau), photonsFor(tau, r), name.str() + ", normal");
        const double rd = c["diffuse"]["R_total"], td = c["diffuse"]["T_total"];
        expectCase(v, diffuse(WalkSource::Kind::DiffuseTop), rd, td, 2 * expIntegral(3, tau), photonsFor(tau, rd),
                   name.str() + ", diffuse");
        ++compared;
    }
    EXPECT_EQ(compared, 6);
}

// THEORY 5.1, computed by adding-doubling; not among the cases of the file.
TEST(WalkSlab, StronglyForwardScattering) {
    expectCase(slab(10, 0.99, 0.9), normalLight(), 0.247628, 0.589082, std::exp(-10), 2000, "normal");
    expectCase(slab(10, 0.99, 0.9), diffuse(WalkSource::Kind::DiffuseTop), 0.375712, 0.450855, 2 * expIntegral(3, 10),
               2000, "diffuse");
}

TEST(WalkSlab, VanDeHulst) {
    expectCase(slab(2, 0.9, 0.75), normalLight(), 0.0973946, 0.6609577, std::exp(-2), 4000, "tau 2, g 0.75");
}

// Low albedos live by the roulette. Half infinite to 1e-9; mu = 1 is the last of the table.
TEST(WalkSlab, LowAlbedosAgainstTheHFunction) {
    const nlohmann::json data = reference("hfunc.json");
    for (const char* albedo : {"0.1", "0.2", "0.3", "0.5"}) {
        const auto& row = data["table"][albedo];
        const WalkMedium medium(slab(30, std::stod(albedo), 0));
        const auto r = [](const WalkTally& b) { return reflectance(b); };
        EXPECT_TRUE(agrees(estimate(walkBatches(medium, normalLight(), 64, 16000), r),
                           row["R_plane"].back().get<double>(), 0.004))
            << albedo;
        EXPECT_TRUE(agrees(estimate(walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 64, 16000), r),
                           row["R_sph"].get<double>(), 0.004))
            << albedo;
    }
}

TEST(WalkSlab, ConservativeMedium) {
    expectCase(slab(1, 1, 0), normalLight(), 0.341329, 0.658671, std::exp(-1), 4000, "normal");
    expectCase(slab(1, 1, 0), diffuse(WalkSource::Kind::DiffuseTop), 0.446594, 0.553406, 2 * expIntegral(3, 1), 4000,
               "diffuse");
    const Progress progress;
    const WalkTally t = WalkMedium(slab(5, 1, 0.9)).walk(normalLight(), 1, 0, 0, 5000, progress);
    EXPECT_EQ(absorptance(t), 0) << "albedo 1 absorbs nothing";
    EXPECT_EQ(t.above.x + channelSum(t.below, 0) + channelSum(t.belowUncollided, 0), 5000);
}

TEST(WalkSlab, NearlyConservativeMediumEnds) {
    for (float albedo : {1.0f, 1 - 1e-7f}) {
        const Progress progress;
        const WalkTally t = WalkMedium(slab(50, double(albedo), 0)).walk(normalLight(), 1, 0, 0, 2000, progress);
        EXPECT_LT(absorptance(t), 1e-4);
        EXPECT_LT(imbalance(t), kRounding);
        EXPECT_GT(t.collisions, 2000u);
    }
}

TEST(WalkSlab, BlackMediumFollowsBeerAndLambert) {
    for (double tau : {0.1, 1.0, 4.0}) {
        const std::uint64_t photons = tau > 2 ? 40000 : 4000;
        const auto normal = walkBatches(WalkMedium(slab(tau, 0, 0)), normalLight(), 64, photons);
        const auto t = [](const WalkTally& b) { return transmittance(b); };
        EXPECT_TRUE(agrees(estimate(normal, t), std::exp(-tau))) << tau;
        const auto diffuseLight =
            walkBatches(WalkMedium(slab(tau, 0, 0)), diffuse(WalkSource::Kind::DiffuseTop), 64, photons);
        EXPECT_TRUE(agrees(estimate(diffuseLight, t), 2 * expIntegral(3, tau))) << tau;
        for (const WalkTally& b : normal) {
            ASSERT_EQ(channelSum(b.collided, 0), 0) << "absorbed at the first collision";
            ASSERT_EQ(channelSum(b.below, 0), 0);
            ASSERT_EQ(b.above.x, 0);
        }
    }
}

TEST(WalkSlab, ObliqueLight) {
    const double tau = 1, mu = 0.4, s = std::sqrt(1 - mu * mu);
    WalkSource source;
    source.towardsLight = Vec3f(float(s * 0.6), float(-s * 0.8), float(mu));
    for (auto kind : {WalkSource::Kind::Direction, WalkSource::Kind::AnyAzimuth}) {
        source.kind = kind;
        const auto batches = walkBatches(WalkMedium(slab(tau, 0, 0)), source, 64, 20000);
        EXPECT_TRUE(
            agrees(estimate(batches, [](const WalkTally& b) { return transmittance(b); }), std::exp(-tau / mu)));
        // Track length of uncollided light: (1 - exp(-tau / mu)) / kappa per photon.
        const double kappa = tau / 1.5;
        const auto track = [](const WalkTally& b) { return channelSum(b.uncollided, 0) / double(b.photons); };
        EXPECT_TRUE(agrees(estimate(batches, track), (1 - std::exp(-tau / mu)) / kappa));
    }
}

TEST(WalkSlab, LightEntersWhereItsDirectionSays) {
    // One opaque black layer below: a beam from +x lands at its entry minus the shift, in the right column.
    BaseVolume v = homogeneous({8, 8, 2}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f));
    for (int x = 0; x < 4; ++x) {
        for (int y = 0; y < 8; ++y) {
            v.extinction[v.index(x, y, 0)] = Rgb(1e6f); // a roof over half of the tile
        }
    }
    WalkSource source;
    source.towardsLight = normalize(Vec3f(1, 0, 2)); // moves half a voxel towards -x per layer
    const auto batches = walkBatches(WalkMedium(v), source, 16, 10000);
    const auto share = [](int x) {
        return [x](const WalkTally& b) {
            double sum = 0;
            for (int y = 0; y < 8; ++y) {
                sum += b.belowUncollided[std::size_t(x + 8 * y) * 3];
            }
            return 8 * sum / double(b.photons);
        };
    };
    // Light enters at x in 4..8 and leaves at x - 1; what comes in under the roof's edge at x in 4..4.5 is stopped.
    EXPECT_TRUE(agrees(estimate(batches, share(6)), 1, 0.02));
    EXPECT_TRUE(agrees(estimate(batches, share(3)), 0.5, 0.02));
    EXPECT_EQ(estimate(batches, share(1)).mean, 0);
    EXPECT_EQ(estimate(batches, share(7)).mean, 0);
}

} // namespace
