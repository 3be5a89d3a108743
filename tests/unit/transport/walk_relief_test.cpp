// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/fresnel.h"
#include "tests/unit/support/chi_square.h"
#include "tests/unit/support/files.h"
#include "tests/unit/transport/reliefs.h"
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

BaseVolume carved(const Relief& relief, const Vec3d& voxelMm, int layers, double kappa, double albedo, double g,
                  double n) {
    BaseVolume v =
        homogeneous({int(relief.depth.size()), 2, layers}, voxelMm, Rgb(float(kappa)), Rgb(float(albedo)), float(g));
    relief.carve(v);
    if (n != 1) {
        v.ior.assign(v.voxelCount(), float(n));
    }
    return v;
}

// Black and of index 1: what arrives below is the mean of exp(-kappa l) over the lines of the light.
void expectBeerAndLambert(const Relief& relief, double mu, std::uint64_t seed, ChiSquare& chi) {
    SCOPED_TRACE("mu " + std::to_string(mu));
    const Vec3d mm(0.5, 0.8, 0.4);
    const double kappa = 1.5;
    const int layers = 6;
    const TileMedium medium = trueMedium(carved(relief, mm, layers, kappa, 0, 0, 1));
    const int lines = 200;
    const double nx = double(relief.depth.size());
    double expected = 0;
    for (int i = 0; i < lines; ++i) {
        const double x = (i + 0.5) * nx / lines;
        expected +=
            std::exp(-kappa * relief.lengthInside(x, -std::sqrt(1 - mu * mu) / mm.x, mu / mm.z, layers)) / lines;
    }
    const auto batches = walkBatches(medium, obliqueLight(mu), 32, 4000, fluenceRequest(0, seed));
    std::vector<std::vector<double>> t(1);
    for (const WalkTally& b : batches) {
        t[0].push_back(transmittance(b));
        ASSERT_NEAR(transmittance(b) + absorptance(b), 1, 1e-9);
        ASSERT_EQ(b.specular.x, 0);
        // Tracks are of the material alone.
        ASSERT_NEAR(channelSum(b.uncollided, 0) * kappa / double(b.photons), absorptance(b), 0.05);
    }
    EXPECT_TRUE(agrees(estimate(t[0]), expected, 0.12, 5e-4 * expected));
    chi.add(t, {expected});
}

TEST(WalkRelief, BlackReliefAbsorbsWhatItsShapeSays) {
    ChiSquare chi;
    std::uint64_t seed = 0;
    for (const Relief& relief : {waves(8, 2.5, 1.5), stairs(8, 1.2, 4.3), groove(8, 0.5, 5)}) {
        for (double mu : {1.0, 0.7, 0.3}) {
            expectBeerAndLambert(relief, mu, ++seed, chi);
        }
    }
    EXPECT_TRUE(chi.holds("black reliefs"));
}

// Normal light on sides of 45 degrees: one reflection sends it across, the second one up; nothing else returns.
TEST(WalkRelief, GrooveReflectsTwice) {
    const double n = 1.5, f = double(fresnelReflectance(float(std::sqrt(0.5)), float(n)));
    const TileMedium medium = trueMedium(carved(groove(8, 0.5, 4.5), {0.3, 0.3, 0.3}, 6, 1e5, 0, 0, n));
    const auto batches = walkBatches(medium, normalLight(), 64, 20000, totalsRequest());
    EXPECT_TRUE(agrees(estimate(batches, [](const WalkTally& b) { return reflectance(b); }), f * f, 0.03));
    for (const WalkTally& b : batches) {
        ASSERT_EQ(b.specular.x, b.above.x) << "it never was inside";
        ASSERT_NEAR(reflectance(b) + absorptance(b), 1, 1e-9);
    }
}

// The first voxels' middles, a face and a place between: R and T are those of a slab with a flat top.
TEST(WalkRelief, FlatSurfaceInsideTheTileIsAFlatTop) {
    ChiSquare chi;
    const nlohmann::json data = reference("slab_cases.json");
    std::uint64_t seed = 0;
    for (const auto& c : data["cases"]) {
        const double tau = c["tau"], albedo = c["albedo"], g = c["g"], n = c["n"];
        if (n == 1 || tau > 10) {
            continue;
        }
        for (double depth : {0.5, 1.0, 1.7}) {
            SCOPED_TRACE("tau " + std::to_string(tau) + ", n " + std::to_string(n) + ", depth " +
                         std::to_string(depth));
            const int layers = 4;
            const BaseVolume v = carved(Relief{std::vector<double>(2, depth)}, {0.5, 0.6, 0.25}, layers,
                                        tau / (0.25 * (layers - depth)), albedo, g, n);
            const TileMedium medium = trueMedium(v, true);
            for (bool normal : {true, false}) {
                const auto& e = normal ? c["normal"] : c["diffuse"];
                const auto batches = walkBatches(medium, normal ? normalLight() : diffuse(WalkSource::Kind::DiffuseTop),
                                                 32, tau > 2 ? 300 : 1200, totalsRequest(0, ++seed));
                std::vector<std::vector<double>> values(2);
                for (const WalkTally& b : batches) {
                    values[0].push_back(reflectance(b));
                    values[1].push_back(transmittance(b));
                    ASSERT_LT(imbalance(b), kRounding);
                    ASSERT_EQ(b.lost, 0u);
                }
                const std::vector<double> expected{e["R_total"], e["T_total"]};
                EXPECT_TRUE(agrees(estimate(values[0]), expected[0], 0.05));
                EXPECT_TRUE(agrees(estimate(values[1]), expected[1], 0.05));
                chi.add(values, expected);
            }
        }
    }
    EXPECT_TRUE(chi.holds("flat surfaces inside the tile"));
    EXPECT_EQ(chi.count(), 60);
}

// Between radiance 1 outside and n^2 below (or 1 below an open bottom) there is n^2 everywhere inside.
void expectFurnace(const Relief& relief, double n, bool open, std::uint64_t seed) {
    SCOPED_TRACE("n " + std::to_string(n) + (open ? ", open bottom" : ""));
    const Vec3d mm(0.5, 0.8, 0.4);
    const BaseVolume v = carved(relief, mm, 6, 1.5, 1, 0.4, n);
    const TileMedium medium = trueMedium(v, open);
    const std::uint64_t photons = 3000;
    WalkRequest request = fluenceRequest(0, seed);
    request.flux = true;
    const auto top = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 32, photons, request);
    request.seed += 1;
    const auto bottom = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 32, photons, request);
    const double voxel = v.voxelMm.x * v.voxelMm.y * v.voxelMm.z, area = v.extentMm().x * v.extentMm().y;
    const double below = open ? 1 : n * n, scale = kPi * area / double(photons);
    int compared = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const double fill = double(medium.fill(i));
        // The share of a cut voxel is known to 0.004 of it.
        if (fill < 0.3) {
            continue;
        }
        for (std::size_t k = 0; k < 4; ++k) {
            std::vector<double> values;
            for (std::size_t b = 0; b < top.size(); ++b) {
                const std::size_t at = i * 12 + k;
                values.push_back(scale / (voxel * fill) *
                                 (top[b].collided[at] + top[b].uncollided[at] +
                                  below * (bottom[b].collided[at] + bottom[b].uncollided[at])));
            }
            const Estimate e = estimate(values);
            const double expected = k == 0 ? 4 * kPi * n * n : 0;
            EXPECT_LT(e.sigma, 0.03 * 4 * kPi * n * n);
            EXPECT_LE(std::abs(e.mean - expected), 4.5 * e.sigma + (fill < 1 ? 0.004 / fill * 4 * kPi * n * n : 0))
                << "voxel " << i << ", fill " << fill << ", component " << k;
            ++compared;
        }
    }
    EXPECT_GT(compared, 50);
    for (std::size_t b = 0; b < top.size(); ++b) {
        ASSERT_LT(imbalance(top[b]), kRounding);
        ASSERT_LT(imbalance(bottom[b]), kRounding);
        ASSERT_EQ(top[b].lost + bottom[b].lost, 0u);
    }
}

TEST(WalkRelief, Furnace) {
    expectFurnace(waves(6, 2.5, 1.5), 1, false, 1);
    expectFurnace(waves(6, 2.5, 1.5), 1.5, false, 3);
    expectFurnace(stairs(6, 1.2, 4.3), 1.5, true, 5);
    expectFurnace(groove(6, 0.5, 5), 1.3, false, 7);
}

// A surface that curves both ways, with ridges up to the flat top and a second material; `deep`: with holes through to
// the bottom.
BaseVolume bumps(double n, double albedo, bool deep) {
    BaseVolume v = homogeneous({6, 5, 6}, {0.4, 0.5, 0.3}, Rgb(2.0f), Rgb(float(albedo)), 0.5f);
    v.surface.resize(v.voxelCount());
    for (int z = 0; z < 6; ++z) {
        for (int y = 0; y < 5; ++y) {
            for (int x = 0; x < 6; ++x) {
                const double s = std::sin(2 * kPi * (x + 0.5) / 6), c = std::cos(2 * kPi * (y + 0.5) / 5);
                const std::size_t i = v.index(x, y, z);
                v.surface[i] = float(0.3 * (deep ? 3 + 4 * s * c : 2.2 + 3 * s * c) - 0.3 * (z + 0.5));
                v.extinction[i] = Rgb(s > 0 ? 4.0f : 0.5f);
            }
        }
    }
    v.ior.assign(v.voxelCount(), float(n));
    return v;
}

TEST(WalkRelief, ConservativeReliefLosesNothing) {
    for (double n : {1.0, 1.0001, 1.5, 2.5}) {
        for (bool open : {true, false}) {
            for (auto kind : {WalkSource::Kind::DiffuseTop, WalkSource::Kind::DiffuseBelow}) {
                const WalkTally t = walkOnce(trueMedium(bumps(n, 1, true), open), diffuse(kind), totalsRequest(3000));
                EXPECT_NEAR(reflectance(t) + transmittance(t) + t.roulette.x / 3000, 1, 1e-9);
                EXPECT_EQ(t.absorbed.x, 0);
                EXPECT_EQ(t.lost, 0u);
            }
            WalkRequest analog = totalsRequest(3000);
            analog.analog = true;
            const WalkTally t = walkOnce(trueMedium(bumps(n, 0.9, true), open), obliqueLight(0.3), analog);
            EXPECT_NEAR(reflectance(t) + transmittance(t) + absorptance(t), 1, 1e-9);
        }
    }
}

// Flux per radiance is the same down and up, where the radiance below counts n^2.
TEST(WalkRelief, DiffuseTransmissionIsReciprocal) {
    std::uint64_t seed = 0;
    for (double n : {1.0, 1.5}) {
        const TileMedium medium = trueMedium(bumps(n, 0.8, false));
        const auto down =
            walkBatches(medium, diffuse(WalkSource::Kind::DiffuseTop), 64, 2000, totalsRequest(0, ++seed));
        const auto up =
            walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 64, 3000, totalsRequest(0, ++seed));
        std::vector<double> difference;
        for (std::size_t b = 0; b < down.size(); ++b) {
            difference.push_back(transmittance(down[b]) - n * n * reflectance(up[b]));
        }
        const Estimate d = estimate(difference);
        EXPECT_LT(d.sigma, 0.015 * transmittance(down[0]));
        EXPECT_LE(std::abs(d.mean), 4 * d.sigma);
    }
}

TEST(WalkRelief, ChannelsAreThoseOfSingleRuns) {
    BaseVolume v = bumps(1.4, 0.9, true);
    for (Rgb& k : v.extinction) {
        k = k * Rgb(0.0f, 1, 1e3f);
    }
    const WalkTally coloured = walkOnce(trueMedium(v), normalLight(), fluenceRequest(1000));
    for (int c = 0; c < 3; ++c) {
        BaseVolume grey = v;
        for (Rgb& k : grey.extinction) {
            k = Rgb(k[c]);
        }
        const WalkTally t = walkOnce(trueMedium(grey), normalLight(), fluenceRequest(1000));
        EXPECT_EQ(t.above[c], coloured.above[c]);
        EXPECT_EQ(t.absorbed[c], coloured.absorbed[c]);
        EXPECT_EQ(t.specular[c], coloured.specular[c]);
        EXPECT_EQ(channelSum(t.collided, c), channelSum(coloured.collided, c));
    }
}

} // namespace
