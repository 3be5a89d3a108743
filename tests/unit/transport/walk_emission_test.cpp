// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/support/chi_square.h"
#include "tests/unit/transport/reliefs.h"
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

const WalkSource kEmission = diffuse(WalkSource::Kind::Emission);

// What one photon stands for, per area of the tile: 4 pi times the mean emission over channels and voxels, times depth.
double perPhoton(const TileMedium& m) {
    double sum = 0;
    for (std::size_t i = 0; i < m.voxelCount(); ++i) {
        sum += double(average(m.emission(i))) * double(m.fill(i));
    }
    return 4 * kPi * sum * m.voxelMm().z / (double(m.size().x) * m.size().y);
}

TEST(WalkEmission, ThinSlabEmits4PiPerVolume) {
    BaseVolume v = homogeneous({2, 1, 4}, {0.5, 0.7, 0.25}, Rgb(1e-5f), Rgb(0.5f));
    v.emission.assign(v.voxelCount(), Rgb(0.5f, 2, 3));
    const TileMedium medium = trueMedium(v);
    ASSERT_TRUE(medium.emits());
    const WalkTally t = walkOnce(medium, kEmission, 20000);
    for (int c = 0; c < 3; ++c) {
        const double out = (reflectance(t, c) + transmittance(t, c)) * perPhoton(medium);
        EXPECT_NEAR(out, 4 * kPi * double(v.emission[0][c]), 0.001 * out); // 1 mm
        EXPECT_NEAR(reflectance(t, c) / transmittance(t, c), 1, 0.06);
    }
}

// Without scattering: flux out of each face pi e / kappa (1 - 2 E3(tau)), and the same fluence at every place by the
// integral over its lines of sight.
TEST(WalkEmission, BlackSlabGlowsAsItAbsorbs) {
    ChiSquare chi;
    std::uint64_t seed = 0;
    for (double tau : {0.3, 3.0}) {
        const int layers = 6;
        BaseVolume v = homogeneous({1, 1, layers}, {1, 1, 1.0 / layers}, Rgb(float(tau)), Rgb(0.0f));
        v.emission.assign(v.voxelCount(), Rgb(float(tau))); // of unit source function
        const TileMedium medium = trueMedium(v);
        const auto batches = walkBatches(medium, kEmission, 64, 6000, fluenceRequest(0, ++seed));
        const double out = kPi * (1 - 2 * expIntegral(3, tau));
        std::vector<std::vector<double>> values(3);
        for (const WalkTally& b : batches) {
            const double scale = perPhoton(medium);
            values[0].push_back(scale * reflectance(b));
            values[1].push_back(scale * transmittance(b));
            values[2].push_back(scale * b.uncollided[2 * 3] / double(b.photons) * layers); // third layer
            ASSERT_LT(imbalance(b), kRounding);
        }
        // Mean over the layer of 2 pi (2 - E2(kappa z) - E2(kappa (h - z))), where INT E2 = 1/2 - E3 and so on.
        const double a = tau * 2 / layers, b = tau * 3 / layers;
        const double fluence =
            2 * kPi *
            (2 - (expIntegral(3, a) - expIntegral(3, b) + expIntegral(3, tau - b) - expIntegral(3, tau - a)) / (b - a));
        const std::vector<double> expected{out, out, fluence};
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_TRUE(agrees(estimate(values[k]), expected[k])) << k;
        }
        chi.add(values, expected);
    }
    EXPECT_TRUE(chi.holds("glowing black slabs"));
}

// Voxels of a temperature: they emit what they would absorb of radiance n^2. In a room of the same temperature
// (radiance 1 on all sides) there is n^2 everywhere, whatever they scatter (Kirchhoff).
void expectEquilibrium(BaseVolume v, double n, bool open, std::uint64_t seed) {
    SCOPED_TRACE("n " + std::to_string(n) + (v.surface.empty() ? "" : ", relief"));
    CounterRng rng(seed, 0);
    if (n != 1) {
        v.ior.assign(v.voxelCount(), float(n));
    }
    v.emission.resize(v.voxelCount());
    v.g.resize(v.voxelCount());
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.extinction[i] = Rgb(0.2f + 3 * rng.uniform());
        v.albedo[i] = Rgb(rng.uniform());
        v.g[i] = 1.4f * rng.uniform() - 0.7f;
        v.emission[i] = v.extinction[i] * (Rgb(1.0f) - v.albedo[i]) * float(n * n);
    }
    const TileMedium medium = trueMedium(v, open);
    // Voxels cut by a surface take another's coefficients, emission included: what they emit still fits.
    const std::uint64_t photons = 3000;
    const auto run = [&](WalkSource::Kind kind) {
        return walkBatches(medium, diffuse(kind), 32, photons, fluenceRequest(0, ++seed));
    };
    const auto top = run(WalkSource::Kind::DiffuseTop), bottom = run(WalkSource::Kind::DiffuseBelow),
               own = run(WalkSource::Kind::Emission);
    const double area = v.extentMm().x * v.extentMm().y, voxel = v.voxelMm.x * v.voxelMm.y * v.voxelMm.z;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const double fill = double(medium.fill(i));
        if (fill < 0.3) {
            continue;
        }
        const auto track = [&](const WalkTally& t) {
            return (t.collided[i * 3] + t.uncollided[i * 3]) * area / (double(photons) * voxel * fill);
        };
        std::vector<double> values;
        for (std::size_t b = 0; b < top.size(); ++b) {
            values.push_back(kPi * track(top[b]) + kPi * (open ? 1 : n * n) * track(bottom[b]) +
                             perPhoton(medium) * track(own[b]));
        }
        EXPECT_TRUE(agrees(estimate(values), 4 * kPi * n * n, 0.03, fill < 1 ? 0.004 / fill * 4 * kPi * n * n : 0))
            << "voxel " << i << ", fill " << fill;
    }
}

TEST(WalkEmission, ThermalEquilibrium) {
    const BaseVolume flat = homogeneous({2, 2, 3}, {0.6, 0.9, 0.5}, Rgb(1.0f), Rgb(0.0f));
    expectEquilibrium(flat, 1, false, 10);
    expectEquilibrium(flat, 1.5, true, 20);
    expectEquilibrium(flat, 1.3, false, 30);
    BaseVolume relief = homogeneous({6, 1, 5}, {0.5, 0.8, 0.4}, Rgb(1.0f), Rgb(0.0f));
    waves(6, 2, 1.4).carve(relief);
    expectEquilibrium(relief, 1, false, 40);
    expectEquilibrium(relief, 1.4, false, 50);
}

// What is emitted leaves or is absorbed, channel by channel; every form, refracted or not.
TEST(WalkEmission, EnergyBalance) {
    BaseVolume v = homogeneous({3, 2, 4}, {0.6, 0.9, 0.5}, Rgb(2.0f), Rgb(0.7f, 0.9f, 0), 0.6f);
    v.emission.resize(v.voxelCount());
    CounterRng rng(3, 3);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.emission[i] = i % 3 == 1 ? Rgb(0.0f) : Rgb(rng.uniform(), 5 * rng.uniform(), 0);
        v.extinction[i] = Rgb(i % 7 == 2 ? 0.0f : 2.0f); // a void may glow
    }
    for (double n : {1.0, 1.5}) {
        if (n != 1) {
            v.ior.assign(v.voxelCount(), float(n));
        }
        for (bool analog : {false, true}) {
            WalkRequest request = totalsRequest();
            request.analog = analog;
            const TileMedium medium(v, n == 1 ? TransportForm::DE1 : TransportForm::Classic, true);
            const auto batches = walkBatches(medium, kEmission, 32, 2000, request);
            for (int c = 0; c < 3; ++c) {
                double emitted = 0;
                for (const Rgb& e : v.emission) {
                    emitted += 4 * kPi * double(e[c]) * v.voxelMm.z / (v.size.x * v.size.y);
                }
                const Estimate all = estimate(batches, [&](const WalkTally& t) {
                    return perPhoton(medium) * (reflectance(t, c) + transmittance(t, c) + absorptance(t, c) +
                                                t.roulette[c] / double(t.photons));
                });
                EXPECT_NEAR(all.mean, emitted, 4 * all.sigma + 1e-6 * emitted) << c;
                EXPECT_LE(all.sigma, 0.01 * emitted);
            }
        }
    }
}

TEST(WalkEmission, DarkVolumesEmitNothing) {
    const WalkTally t = walkOnce(trueMedium(homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(1.0f), Rgb(0.5f))), kEmission, 100);
    EXPECT_EQ(t.photons, 100u);
    EXPECT_EQ(t.above.x + channelSum(t.below, 0) + channelSum(t.uncollided, 0), 0);
}

} // namespace
