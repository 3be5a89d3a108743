// SPDX-License-Identifier: Apache-2.0
// A flat shell rendered at a fine quality, seen from five sides: within half a per cent of exact transport.
#include "stfLib/transport/walk.h"
#include "tests/unit/render/slab_fixture.h"

namespace stf::test {
namespace {

constexpr double kViews[] = {1, 0.8, 0.6, 0.4, 0.2};
constexpr double kWanted = 0.005;

Slab fineSlab(double tau, double albedo, double ior) {
    Slab slab;
    slab.tau = tau;
    slab.albedo = albedo;
    slab.ior = ior;
    slab.layersPerMm = 20;
    slab.lit = Slab::Lit::Dome;
    slab.quality = 0.003f;
    slab.settings.samples = 512;
    return slab;
}

// What parallel light from a cosine loses upward, by walks in the true medium: by reciprocity the radiance towards
// there under a white dome.
std::pair<double, double> reflectance(const BaseVolume& volume, double mu) {
    const TileMedium medium(volume, TransportForm::Classic, false);
    WalkSource source;
    source.towardsLight = {float(std::sqrt((1 - mu) * (1 + mu))), 0, float(mu)};
    WalkRequest request;
    request.count = 1'000'000;
    request.voxels = false;
    const WalkTally t = walk(medium, source, request, Progress());
    const double n = double(t.photons), mean = t.above.x / n;
    return {mean, std::sqrt((t.aboveSquared.x / n - mean * mean) / n)};
}

void expectWithin(const Slab::Measured& r, double exact, double error, double mu, double ior) {
    std::printf("index %.1f, cosine %.1f: %.5f, exact %.5f: %+.2f %%, standard errors %.2f and %.2f %%\n", ior, mu,
                r.mean, exact, 100 * (r.mean / exact - 1), 100 * r.error / exact, 100 * error / exact);
    EXPECT_LE(r.error + error, kWanted * exact) << "too noisy to tell";
    EXPECT_LE(std::abs(r.mean - exact), kWanted * exact + 4 * std::hypot(r.error, error))
        << "index " << ior << ", view " << mu;
}

TEST(SlabViews, ExactTransport) {
    for (const double ior : {1.0, 1.3, 1.5}) {
        for (const double mu : kViews) {
            Slab slab = fineSlab(4, 0.99, ior);
            slab.viewCosine = mu;
            const auto [exact, error] = reflectance(slab.volume(), mu);
            expectWithin(slab.radiance(), exact, error, mu, ior);
        }
    }
}

// With light from the core: its balance divides by what the shell lets out.
TEST(SlabViews, WhiteFurnaceWithACore) {
    for (const double ior : {1.0, 1.3, 1.5}) {
        for (const double mu : {1.0, 0.6, 0.2}) {
            Slab slab = fineSlab(1, 1, ior);
            slab.coreAlbedo = 1;
            slab.viewCosine = mu;
            slab.settings.samples = 128;
            expectWithin(slab.radiance(), 1, 0, mu, ior);
        }
    }
}

// Helmholtz: light and view exchanged give the same radiance per irradiance of the surface. Directions of one table
// differ by its own error: the mean of several.
TEST(SlabViews, Reciprocity) {
    constexpr int kTables = 3;
    for (const double ior : {1.0, 1.5}) {
        double told[2] = {0, 0}, error[2] = {0, 0};
        const double cosines[] = {0.9, 0.4};
        for (int k = 0; k < 2; ++k) {
            for (std::uint64_t seed = 0; seed < kTables; ++seed) {
                Slab slab = fineSlab(4, 0.99, ior);
                slab.lit = Slab::Lit::Distant;
                slab.lightCosine = cosines[k];
                slab.viewCosine = cosines[1 - k];
                slab.settings.tableSeed = seed;
                const Slab::Measured r = slab.radiance();
                told[k] += r.mean / cosines[k] / kTables;
                error[k] = std::hypot(error[k], r.error / cosines[k] / kTables);
            }
        }
        std::printf("index %.1f: %.5f there, %.5f back\n", ior, told[0], told[1]);
        EXPECT_LE(std::abs(told[0] - told[1]), kWanted * told[0] + 4 * std::hypot(error[0], error[1])) << ior;
    }
}

} // namespace
} // namespace stf::test
