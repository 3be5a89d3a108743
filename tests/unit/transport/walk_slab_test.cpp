// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/support/chi_square.h"
#include "tests/unit/support/files.h"
#include "tests/unit/transport/walks.h"

#include <sstream>

using namespace stf;
using namespace stf::test;

namespace {

struct Layer {
    double tau, albedo, g;
};

// An anisotropic tile of several columns, laterally homogeneous; each layer of material is `sublayers` of voxels.
BaseVolume slab(const std::vector<Layer>& layers, double n = 1, int sublayers = 1) {
    const Vec3d voxelMm(0.5, 0.8, 0.3);
    BaseVolume v = homogeneous({2, 3, int(layers.size()) * sublayers}, voxelMm, Rgb(0.0f), Rgb(0.0f));
    v.g.resize(v.voxelCount());
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const Layer& l = layers[i / 6 / std::size_t(sublayers)];
        v.extinction[i] = Rgb(float(l.tau / (voxelMm.z * sublayers)));
        v.albedo[i] = Rgb(float(l.albedo));
        v.g[i] = float(l.g);
    }
    if (n != 1) {
        v.ior.assign(v.voxelCount(), float(n));
    }
    return v;
}
BaseVolume slab(double tau, double albedo, double g, double n = 1) {
    return slab(std::vector<Layer>{{tau, albedo, g}}, n, 5);
}

constexpr int kBatches = 64;

// As many photons per batch as take a fixed number of collisions.
std::uint64_t photonsFor(const TileMedium& medium, const WalkSource& source, double collisionsPerBatch) {
    const WalkTally pilot = walkOnce(medium, source, totalsRequest(50, 99));
    const double each = 1 + double(pilot.collisions) / double(pilot.photons);
    return std::uint64_t(std::min(20000.0, std::max(16.0, collisionsPerBatch / each)));
}

// Totals of a source against exact ones; adds all that are not too rare for it to the chi-square.
void expectTotals(const TileMedium& medium, const WalkSource& source, double r, double t, double unscattered,
                  const std::string& name, ChiSquare& chi, double collisionsPerBatch = 12000) {
    SCOPED_TRACE(name);
    // Another seed each time: with the same numbers, the deviations of similar cases would be alike.
    const std::uint64_t photons = photonsFor(medium, source, collisionsPerBatch), seed = 1 + std::uint64_t(chi.count());
    const auto batches = walkBatches(medium, source, kBatches, photons, totalsRequest(0, seed));
    std::vector<std::vector<double>> quantities;
    std::vector<double> expected;
    const auto compare = [&](const char* what, double exact, double (*value)(const WalkTally&)) {
        std::vector<double> numbers;
        for (const WalkTally& b : batches) {
            numbers.push_back(value(b));
        }
        const Estimate e = estimate(numbers);
        if (!(e.sigma > 0)) {
            EXPECT_NEAR(e.mean, exact, 4.0 / double(photons * kBatches)) << what;
        } else if (e.sigma < 0.05 * exact) {
            EXPECT_TRUE(agrees(e, exact, 0.05)) << what;
            quantities.push_back(std::move(numbers));
            expected.push_back(exact);
        } else {
            EXPECT_LE(std::abs(e.mean - exact), 5 * e.sigma + 1e-6) << what;
        }
    };
    compare("R", r, [](const WalkTally& b) { return reflectance(b); });
    compare("T", t, [](const WalkTally& b) { return transmittance(b); });
    if (1 - r - t == 0 || 1 - r - t > 1e-4) { // the difference of numbers with seven digits
        compare("A", 1 - r - t, [](const WalkTally& b) { return absorptance(b); });
    }
    // What the collisions add, by itself: it is small in thin slabs.
    if (unscattered >= 0) {
        compare("T scattered", t - unscattered,
                [](const WalkTally& b) { return transmittance(b) - transmittedUncollided(b); });
    }
    EXPECT_GE(quantities.size(), 1u);
    chi.add(quantities, expected);

    WalkTally all;
    for (const WalkTally& b : batches) {
        for (int c = 0; c < 3; ++c) {
            ASSERT_LT(imbalance(b, c), kRounding);
        }
        ASSERT_EQ(b.lost, 0u);
        all.add(b);
    }
    // Without what roulette took: three numbers that were tallied on their own.
    const double sigma = std::hypot(
        standardError(all.above.x, all.aboveSquared.x, all.photons),
        standardError(channelSum(all.below, 0) + channelSum(all.belowUncollided, 0), all.belowSquared.x, all.photons),
        standardError(all.absorbed.x, all.absorbedSquared.x, all.photons));
    EXPECT_LE(std::abs(reflectance(all) + transmittance(all) + absorptance(all) - 1), 3 * sigma + 1e-9);
}

TEST(WalkSlab, ReferenceSlabs) {
    ChiSquare chi;
    int compared = 0;
    const nlohmann::json data = reference("slab_cases.json");
    for (const auto& c : data["cases"]) {
        const double tau = c["tau"], albedo = c["albedo"], g = c["g"], n = c["n"];
        std::ostringstream name;
        name << "tau " << tau << ", albedo " << albedo << ", g " << g << ", n " << n;
        const TileMedium medium = trueMedium(slab(tau, albedo, g, n), true);
        expectTotals(medium, normalLight(), c["normal"]["R_total"], c["normal"]["T_total"],
                     c["normal"]["T_unscattered"], name.str() + ", normal", chi);
        expectTotals(medium, diffuse(WalkSource::Kind::DiffuseTop), c["diffuse"]["R_total"], c["diffuse"]["T_total"],
                     -1, name.str() + ", diffuse", chi);
        ++compared;
    }
    EXPECT_EQ(compared, 14);
    EXPECT_TRUE(chi.holds("homogeneous slabs"));
    EXPECT_GE(chi.count(), 70);
}

TEST(WalkSlab, LayeredSlabs) {
    ChiSquare chi;
    int compared = 0;
    const nlohmann::json data = reference("slab_cases.json");
    for (const auto& c : data["layered"]) {
        std::vector<Layer> layers;
        for (const auto& l : c["layers"]) {
            layers.push_back({l["tau"], l["albedo"], l["g"]});
        }
        const TileMedium medium = trueMedium(slab(layers, c["n"]), true);
        const std::string name = c["name"];
        expectTotals(medium, normalLight(), c["R_total_normal"], c["T_total_normal"], -1, name + ", normal", chi);
        expectTotals(medium, diffuse(WalkSource::Kind::DiffuseTop), c["R_total_diffuse"], c["T_total_diffuse"], -1,
                     name + ", diffuse", chi);
        ++compared;
    }
    EXPECT_EQ(compared, 3);
    EXPECT_TRUE(chi.holds("layered slabs"));
}

// Not among the cases of the file: THEORY 5.1 and van de Hulst 1980, "Multiple Light Scattering", table 35.
TEST(WalkSlab, ForwardAndConservativeSlabs) {
    ChiSquare chi;
    const auto both = [&](double tau, double albedo, double g, double n, double r, double t, double rd, double td) {
        std::ostringstream name;
        name << "tau " << tau << ", albedo " << albedo << ", g " << g << ", n " << n;
        const TileMedium medium = trueMedium(slab(tau, albedo, g, n), true);
        expectTotals(medium, normalLight(), r, t, n == 1 ? std::exp(-tau) : -1, name.str() + ", normal", chi);
        if (rd > 0) {
            expectTotals(medium, diffuse(WalkSource::Kind::DiffuseTop), rd, td, n == 1 ? 2 * expIntegral(3, tau) : -1,
                         name.str() + ", diffuse", chi);
        }
    };
    both(10, 0.99, 0.9, 1, 0.247628, 0.589082, 0.375712, 0.450855);
    both(2, 0.9, 0.75, 1, 0.0973946, 0.6609577, 0.191090, 0.501816);
    both(1, 1, 0, 1, 0.341329, 0.658671, 0.446594, 0.553406);
    both(1, 0.9, 0, 1.33, 0.225472, 0.541360, 0.284770, 0.469074);
    both(0.01, 0.9, 0.9, 1.5, 0.077029, 0.921471, 0.155446, 0.842154);
    both(5, 0.999999, -0.9, 1.5, 0.804182, 0.195798, 0.804649, 0.195329);
    EXPECT_TRUE(chi.holds("slabs of THEORY 5.1"));
}

// Half infinite to 1e-9, at all angles. Low albedos live by the roulette.
TEST(WalkSlab, HFunction) {
    ChiSquare chi;
    const nlohmann::json data = reference("hfunc.json");
    for (const char* albedo : {"0.1", "0.3", "0.5", "0.8", "0.95"}) {
        const auto& row = data["table"][albedo];
        const TileMedium medium = trueMedium(slab(std::stod(albedo) > 0.9 ? 60 : 30, std::stod(albedo), 0));
        for (std::size_t i : {std::size_t(0), std::size_t(3), data["mu"].size() - 1}) {
            const double mu = std::stod(data["mu"][i].get<std::string>());
            for (auto kind : {WalkSource::Kind::Direction, WalkSource::Kind::AnyAzimuth}) {
                expectTotals(medium, obliqueLight(mu, kind), row["R_plane"][i], 0, 0,
                             "albedo " + std::string(albedo) + ", mu " + std::to_string(mu), chi, 6000);
            }
        }
        expectTotals(medium, diffuse(WalkSource::Kind::DiffuseTop), row["R_sph"], 0, 0, albedo, chi, 6000);
    }
    EXPECT_TRUE(chi.holds("half infinite media"));
}

TEST(WalkSlab, AnalogWalksBalanceTheirBooksAndAgree) {
    ChiSquare chi;
    for (double n : {1.0, 1.5}) {
        const TileMedium medium = trueMedium(slab(2, 0.9, 0.5, n), true);
        WalkRequest request = totalsRequest();
        request.analog = true;
        request.seed = n == 1 ? 1 : 3;
        const auto analog = walkBatches(medium, normalLight(), kBatches, 2000, request);
        const auto weighted = walkBatches(medium, normalLight(), kBatches, 2000, totalsRequest(0, request.seed + 1));
        for (const WalkTally& b : analog) {
            ASSERT_EQ(b.roulette.x, 0);
            ASSERT_NEAR(reflectance(b) + transmittance(b) + absorptance(b), 1, 1e-5);
        }
        std::vector<std::vector<double>> difference(3);
        for (std::size_t b = 0; b < analog.size(); ++b) {
            difference[0].push_back(reflectance(analog[b]) - reflectance(weighted[b]));
            difference[1].push_back(transmittance(analog[b]) - transmittance(weighted[b]));
            difference[2].push_back(absorptance(analog[b]) - absorptance(weighted[b]));
        }
        chi.add(difference, {0, 0, 0});
    }
    EXPECT_TRUE(chi.holds("analog against weighted"));
}

// The squares of what each photon gave are the scatter of batches.
TEST(WalkSlab, StandardErrorsAreTheScatterOfBatches) {
    const TileMedium medium = trueMedium(slab(4, 0.95, 0.6, 1.33), true);
    const auto batches = walkBatches(medium, normalLight(), 256, 300, totalsRequest());
    WalkTally all;
    for (const WalkTally& b : batches) {
        all.add(b);
    }
    const auto ratio = [&](double (*value)(const WalkTally&), double sum, double squares) {
        return standardError(sum, squares, all.photons) / estimate(batches, value).sigma;
    };
    // Of 256 batches: a standard error to 4.4 %.
    EXPECT_NEAR(ratio([](const WalkTally& b) { return reflectance(b); }, all.above.x, all.aboveSquared.x), 1, 0.18);
    EXPECT_NEAR(ratio([](const WalkTally& b) { return transmittance(b); },
                      channelSum(all.below, 0) + channelSum(all.belowUncollided, 0), all.belowSquared.x),
                1, 0.18);
    EXPECT_NEAR(ratio([](const WalkTally& b) { return absorptance(b); }, all.absorbed.x, all.absorbedSquared.x), 1,
                0.18);
}

TEST(WalkSlab, ConservativeMedium) {
    const WalkTally t = walkOnce(trueMedium(slab(5, 1, 0.9)), normalLight(), 5000);
    EXPECT_EQ(absorptance(t), 0) << "albedo 1 absorbs nothing";
    EXPECT_EQ(t.above.x + channelSum(t.below, 0) + channelSum(t.belowUncollided, 0), 5000);
}

TEST(WalkSlab, NearlyConservativeMediumEnds) {
    for (float albedo : {1.0f, 1 - 1e-7f}) {
        const WalkTally t = walkOnce(trueMedium(slab(50, double(albedo), 0)), normalLight(), 2000);
        EXPECT_LT(absorptance(t), 1e-4);
        EXPECT_LT(imbalance(t), kRounding);
        EXPECT_GT(t.collisions, 2000u);
    }
}

TEST(WalkSlab, BlackMediumFollowsBeerAndLambert) {
    for (double tau : {0.1, 1.0, 4.0}) {
        const std::uint64_t photons = tau > 2 ? 40000 : 4000;
        const auto normal = walkBatches(trueMedium(slab(tau, 0, 0)), normalLight(), 64, photons);
        const auto t = [](const WalkTally& b) { return transmittance(b); };
        EXPECT_TRUE(agrees(estimate(normal, t), std::exp(-tau))) << tau;
        const auto diffuseLight =
            walkBatches(trueMedium(slab(tau, 0, 0)), diffuse(WalkSource::Kind::DiffuseTop), 64, photons);
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
        const auto batches = walkBatches(trueMedium(slab(tau, 0, 0)), source, 64, 20000);
        EXPECT_TRUE(
            agrees(estimate(batches, [](const WalkTally& b) { return transmittance(b); }), std::exp(-tau / mu)));
        // Track length of uncollided light: (1 - exp(-tau / mu)) / kappa per photon.
        const double kappa = tau / 1.5;
        const auto track = [](const WalkTally& b) { return channelSum(b.uncollided, 0) / double(b.photons); };
        EXPECT_TRUE(agrees(estimate(batches, track), (1 - std::exp(-tau / mu)) / kappa));
        const auto cosine = [](const WalkTally& b) {
            return channelSum(b.belowUncollidedCosine, 0) / channelSum(b.belowUncollided, 0);
        };
        EXPECT_NEAR(estimate(batches, cosine).mean, mu, 1e-6);
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
    const auto batches = walkBatches(trueMedium(v), source, 16, 10000);
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

// Fluxes are tallied along the light's own axes where azimuths are averaged, along the tile's where not.
TEST(WalkSlab, FluxOfUncollidedLightPointsAwayFromIt) {
    const double mu = 0.6;
    for (auto kind : {WalkSource::Kind::Direction, WalkSource::Kind::AnyAzimuth}) {
        WalkRequest request = fluenceRequest(20000);
        request.flux = true;
        const WalkTally t = walkOnce(trueMedium(slab(0.5, 0.9, 0.5)), obliqueLight(mu, kind), request);
        ASSERT_EQ(t.components, 4);
        double sum[4] = {};
        for (std::size_t i = 0; i < t.uncollided.size(); i += 12) {
            for (std::size_t k = 0; k < 4; ++k) {
                sum[k] += t.uncollided[i + k]; // red
            }
        }
        EXPECT_NEAR(sum[1] / sum[0], -0.8, 1e-5) << "away from +x, where the light is";
        EXPECT_NEAR(sum[2] / sum[0], 0, 1e-5);
        EXPECT_NEAR(sum[3] / sum[0], -mu, 1e-5) << "inward";
    }
}

} // namespace
