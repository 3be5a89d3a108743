// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/precompute.h"

#include "tests/unit/support/files.h"
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

StfTable compute(const BaseVolume& v, TransportOptions options, const MessageSink& sink = {}) {
    Progress progress;
    return precompute(v, options, progress, sink);
}

TransportOptions quick(std::uint64_t seed = 0) {
    TransportOptions options;
    options.seed = seed;
    options.quality = 0.3f;
    options.polars = 4;
    options.azimuths = 4;
    return options;
}

// A tile with a void, so that azimuths matter.
BaseVolume relief() {
    BaseVolume v = homogeneous({4, 3, 4}, {1, 1, 1}, Rgb(0.8f), Rgb(0.9f, 0.8f, 0.7f), 0.3f);
    v.extinction[v.index(1, 1, 0)] = Rgb(0.0f);
    return v;
}

// Veins: columns of other optical thickness, so that directions, columns and filter all matter.
BaseVolume veined() {
    BaseVolume v = homogeneous({12, 12, 8}, {0.25, 0.25, 0.25}, Rgb(2.0f), Rgb(0.95f), 0.0f);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const std::size_t x = i % 12, y = i / 12 % 12;
        if ((x + y / 3) % 6 < 2) {
            v.extinction[i] = Rgb(12.0f);
            v.albedo[i] = Rgb(0.6f);
        }
    }
    return v;
}

void expectSame(const StfTable& a, const StfTable& b) {
    EXPECT_TRUE(a.multiple->factors == b.multiple->factors);
    EXPECT_TRUE(a.multiple->basis == b.multiple->basis);
    EXPECT_TRUE(a.backlight->factors == b.backlight->factors);
    EXPECT_TRUE(a.transmitted->factors == b.transmitted->factors);
    EXPECT_TRUE(a.direct->factors == b.direct->factors);
    EXPECT_TRUE(a.reflectedBelow == b.reflectedBelow);
    EXPECT_EQ(a.photons, b.photons);
    EXPECT_EQ(a.error.noise, b.error.noise);
}

bool allFinite(const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

// Fluence or flux of a voxel at the pole, from a table.
double atPole(const FactoredField& f, std::size_t item, int component = 0) {
    return double(f.node(item, 0, component));
}

// Mean of a reference profile over a layer (trapezoids of its rows).
double layerMean(const nlohmann::json& rows, const char* column, double from, double to) {
    const auto value = [&](double depth) {
        for (std::size_t i = 1; i < rows.size(); ++i) {
            const double a = rows[i - 1]["depth"], b = rows[i]["depth"];
            if (depth <= b) {
                const double t = (depth - a) / (b - a);
                return (1 - t) * double(rows[i - 1][column]) + t * double(rows[i][column]);
            }
        }
        return double(rows.back()[column]);
    };
    double sum = 0;
    for (int k = 0; k < 16; ++k) {
        sum += value(from + (to - from) * (k + 0.5) / 16) / 16;
    }
    return sum;
}

TEST(Precompute, DoesNotDependOnThreads) {
    setThreadCount(1);
    const StfTable one = compute(relief(), quick());
    setThreadCount(2);
    const StfTable two = compute(relief(), quick());
    setThreadCount(0);
    expectSame(one, two);
    EXPECT_FALSE(one.multiple->factors == compute(relief(), quick(1)).multiple->factors) << "another seed";
}

TEST(Precompute, ShapeOfTheTable) {
    const StfTable t = compute(relief(), quick());
    EXPECT_EQ(t.size, Vec3i(4, 3, 4));
    EXPECT_EQ(t.directions.count(), 1 + 3 * 4);
    EXPECT_EQ(t.multiple->items(), 48u);
    EXPECT_EQ(t.multiple->components, 12) << "g is not 0: flux is kept";
    EXPECT_EQ(t.multiple->directions, 13);
    EXPECT_EQ(t.transmitted->items(), 12u);
    EXPECT_EQ(t.backlight->items(), 48u);
    EXPECT_EQ(t.reflectedBelow.size(), 12u);
    EXPECT_EQ(t.reflectedAbove.size(), 13u);
    EXPECT_TRUE(t.single->empty()) << "index 1: single scattering is marched";
    EXPECT_TRUE(t.emitted->empty());
    EXPECT_EQ(t.volumeHash, relief().contentHash());
    TransportOptions classic = quick();
    classic.form = TransportForm::Classic;
    EXPECT_EQ(compute(relief(), classic).multiple->components, 3) << "isotropic: no flux";
    BaseVolume refracting = relief();
    refracting.ior.assign(48, 1.3f);
    refracting.surface.assign(48, -1.0f);
    refracting.surface[refracting.index(1, 1, 0)] = 0.4f;
    EXPECT_FALSE(compute(refracting, quick()).single->empty()) << "caustics are walked";
}

TEST(Precompute, HomogeneousTileIsOneColumn) {
    const BaseVolume one = homogeneous({1, 1, 6}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    const BaseVolume many = homogeneous({5, 4, 6}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    const StfTable a = compute(one, quick()), b = compute(many, quick());
    EXPECT_EQ(b.size, Vec3i(1, 1, 6));
    expectSame(a, b);
    EXPECT_NE(a.volumeHash, b.volumeHash);
    BaseVolume stepped = many;
    stepped.surface.assign(many.voxelCount(), -1.0f);
    stepped.surface[0] = 1;
    EXPECT_EQ(compute(stepped, quick()).size, many.size) << "a relief is not uniform";
}

TEST(Precompute, FluenceOfTheReferenceSlabs) {
    const nlohmann::json data = reference("slab_cases.json");
    for (const auto& c : data["internal_fluence"]) {
        const double tau = c["tau"], albedo = c["albedo"], g = c["g"];
        SCOPED_TRACE("tau " + std::to_string(tau) + " g " + std::to_string(g));
        constexpr int kLayers = 20;
        TransportOptions options;
        options.quality = 0.006f;
        options.polars = 6;
        options.form = TransportForm::Classic;
        const BaseVolume v =
            homogeneous({1, 1, kLayers}, {1, 1, tau / kLayers}, Rgb(1.0f), Rgb(float(albedo)), float(g));
        const StfTable classic = compute(v, options);
        options.form = TransportForm::DE1;
        const StfTable scaled = compute(v, options);
        const double f = g > 0 ? g * g : 0, thinner = 1 - albedo * f;
        double squares = 0, total = 0;
        for (int z = 0; z < kLayers; ++z) {
            const double from = tau * z / kLayers, to = tau * (z + 1) / kLayers;
            const double expected = layerMean(c["rows"], "I_m", from, to);
            const double single = (std::exp(-from) - std::exp(-to)) / (to - from);
            // The rows are sparse for the bend below the surfaces.
            const bool outermost = z == 0 || z == kLayers - 1;
            EXPECT_NEAR(atPole(*classic.multiple, std::size_t(z)) / expected, 1, outermost ? 0.04 : 0.03) << z;
            if (!outermost) {
                squares += std::pow(atPole(*classic.multiple, std::size_t(z)) - expected, 2);
                total += expected * expected;
            }
            EXPECT_NEAR(atPole(*classic.backlight, std::size_t(z)) / (2 * kPi), layerMean(c["rows"], "I_b", from, to),
                        0.02);
            // With the scaled medium only the sum of uncollided and collided light compares.
            const double scaledSingle = (std::exp(-from * thinner) - std::exp(-to * thinner)) / ((to - from) * thinner);
            EXPECT_NEAR((atPole(*scaled.multiple, std::size_t(z)) + scaledSingle) / (expected + single), 1,
                        g > 0       ? 0.08
                        : outermost ? 0.03
                                    : 0.015)
                << z;
        }
        EXPECT_LT(std::sqrt(squares / total), 0.012) << "twice the error that was asked for";
    }
}

// What enters and is not reflected goes through: the divergence of the net flux is absorption, none here.
TEST(Precompute, NetFluxOfAConservativeSlab) {
    constexpr int kLayers = 8;
    const double tau = 2;
    TransportOptions options;
    options.quality = 0.005f;
    options.polars = 4;
    const float g = 0.5f;
    const StfTable t = compute(homogeneous({1, 1, kLayers}, {1, 1, tau / kLayers}, Rgb(1.0f), Rgb(1.0f), g), options);
    ASSERT_TRUE(t.multiple->hasFlux());
    const double reflected = double(t.reflectedAbove[0].x), thinner = 1 - 0.25;
    for (int z = 0; z < kLayers; ++z) {
        const double from = thinner * tau * z / kLayers, to = thinner * tau * (z + 1) / kLayers;
        const double uncollided = (std::exp(-from) - std::exp(-to)) / (to - from);
        // z of the flux is outward.
        EXPECT_NEAR(-atPole(*t.multiple, std::size_t(z), 9) + uncollided, 1 - reflected, 0.01) << z;
        EXPECT_NEAR(atPole(*t.multiple, std::size_t(z), 3), 0, 0.01) << "no side is preferred";
    }
    EXPECT_NEAR(double(t.transmitted->node(0, 0, 0)), 1 - reflected, 0.005);
}

// Radiance 1 from all sides outside, from below inside: n^2 everywhere, whatever scatters.
TEST(Precompute, FurnaceFillsTheTile) {
    for (const float n : {1.0f, 1.3f, 1.5f}) {
        SCOPED_TRACE(n);
        BaseVolume v = veined();
        v.albedo.assign(v.voxelCount(), Rgb(1.0f));
        v.ior.assign(v.voxelCount(), n);
        TransportOptions options;
        options.quality = 0.05f;
        options.polars = 8;
        options.azimuths = 1;
        const StfTable t = compute(v, options);
        const TileMedium medium(v, options.form);
        const double expected = 4 * kPi * double(n) * double(n);
        double mean = 0;
        int count = 0;
        for (std::size_t i = 0; i < v.voxelCount(); i += 37, ++count) {
            const Vec3f corner{float(i % 12), float(i / 12 % 12), float(i / 144)};
            CounterRng rng(7, i);
            double sum = double(n) * double(n) * double(t.backlight->node(i, 0, 0));
            constexpr int kTheta = 48, kPhi = 8;
            for (int k = 0; k < kTheta * kPhi; ++k) {
                const double mu = (k / kPhi + 0.5) / kTheta, phi = 2 * kPi * (k % kPhi + 0.5) / kPhi;
                const double s = std::sqrt(1 - mu * mu);
                const Vec3f l{float(s * std::cos(phi)), float(s * std::sin(phi)), float(mu)};
                // The table holds means over voxels.
                const Vec3f p = corner + Vec3f(rng.uniform(), rng.uniform(), rng.uniform());
                sum += 2 * kPi / (kTheta * kPhi) *
                       double(t.multiple->rgb(i, t.directions.weights(l)).x + medium.uncollided(p, l).fraction.x);
            }
            EXPECT_NEAR(sum / expected, 1, 0.12) << i;
            mean += sum / expected;
        }
        EXPECT_NEAR(mean / count, 1, 0.012);
    }
}

// The error that is reported, against the truth: walks of many photons at directions that no table holds.
TEST(Precompute, ReportedErrorIsTheTrueOne) {
    const BaseVolume v = veined();
    for (const float quality : {0.08f, 0.04f}) {
        TransportOptions options;
        options.quality = quality;
        const StfTable t = compute(v, options);
        EXPECT_LE(t.error.total(), 1.15 * double(quality));
        const TileMedium medium(v, options.form);
        double error = 0, signal = 0, noise = 0;
        const double tileArea = 9, voxelVolume = 0.25 * 0.25 * 0.25;
        for (int k = 0; k < 4; ++k) {
            const double mu = 0.95 - 0.2 * k, phi = 1 + 2.4 * k, s = std::sqrt(1 - mu * mu);
            WalkSource source;
            source.towardsLight = {float(s * std::cos(phi)), float(s * std::sin(phi)), float(mu)};
            const auto batches = walkBatches(medium, source, 4, 100000);
            const DirectionWeights w = t.directions.weights(source.towardsLight);
            for (std::size_t i = 0; i < v.voxelCount(); ++i) {
                const auto e = estimate(batches, [&](const WalkTally& b) {
                    return b.collided[i * 3 * std::size_t(b.components)] * mu * tileArea /
                           (double(b.photons) * voxelVolume);
                });
                error += std::pow(double(t.multiple->rgb(i, w).x) - e.mean, 2);
                noise += e.sigma * e.sigma;
                signal += e.mean * e.mean;
            }
        }
        const double measured = std::sqrt(std::max(0.0, error - noise) / signal);
        // What is stored, voxel by voxel, is noisier than what is read between voxels.
        EXPECT_LT(measured, 2.2 * t.error.total()) << "target " << quality;
        EXPECT_GT(measured, 0.5 * t.error.total());
    }
}

TEST(Precompute, DirectionsFollowTheTarget) {
    TransportOptions coarse, fine;
    coarse.quality = 0.1f;
    fine.quality = 0.01f;
    const BaseVolume flat = homogeneous({1, 1, 16}, {1, 1, 0.25}, Rgb(1.0f), Rgb(0.9f));
    const StfTable a = compute(flat, coarse), b = compute(flat, fine);
    EXPECT_LT(a.directions.polars(), b.directions.polars());
    EXPECT_EQ(b.directions.azimuths(), 1) << "laterally uniform";
    EXPECT_LE(b.error.directions, 0.0051);
    EXPECT_LT(b.photons, 3'000'000u) << "a uniform tile costs almost nothing";
    EXPECT_LT(b.multiple->rank, b.directions.count()) << "low rank";
    coarse.quality = 0.08f;
    EXPECT_GT(compute(veined(), coarse).directions.azimuths(), 1) << "shadows turn with the light";
}

TEST(Precompute, ColumnsOfAHomogeneousTileAgreeWithOneColumn) {
    // A difference too small to matter makes the tile go the long way.
    const BaseVolume one = homogeneous({1, 1, 4}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    BaseVolume many = homogeneous({4, 3, 4}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    many.albedo[0] = Rgb(0.9f + 1e-6f);
    ASSERT_FALSE(many.laterallyUniform());
    TransportOptions options;
    options.quality = 0.02f;
    options.polars = 5;
    options.azimuths = 1;
    const StfTable a = compute(one, options), b = compute(many, options);
    ASSERT_EQ(b.size, Vec3i(4, 3, 4));
    for (int d = 0; d < 5; ++d) {
        for (std::size_t z = 0; z < 4; ++z) {
            for (std::size_t column : {0, 5, 11}) {
                EXPECT_NEAR(b.multiple->node(column + 12 * z, d, 0), a.multiple->node(z, d, 0), 0.08) << d << " " << z;
            }
        }
        EXPECT_NEAR(b.transmitted->node(7, d, 0), a.transmitted->node(0, d, 0), 0.05);
    }
    EXPECT_NEAR(double(b.backlight->node(17, 0, 0)) / double(a.backlight->node(1, 0, 0)), 1, 0.08);
    EXPECT_NEAR(double(b.reflectedBelow[3].x), double(a.reflectedBelow[0].x), 0.04);
}

TEST(Precompute, WithoutScatteringNothingIsWalked) {
    for (const Rgb& extinction : {Rgb(0.7f), Rgb(0.0f)}) {
        // The albedo of an empty tile does not matter.
        const Rgb albedo(extinction.x > 0 ? 0.0f : 0.9f);
        const StfTable t = compute(homogeneous({1, 1, 4}, {1, 1, 0.5}, extinction, albedo), {});
        EXPECT_EQ(t.photons, 0u);
        EXPECT_TRUE(t.multiple->empty());
        EXPECT_TRUE(t.backlight->empty());
        const double tau = 2 * double(extinction.x);
        for (int d = 0; d < t.directions.count(); ++d) {
            const double mu = double(t.directions.direction(d).z);
            EXPECT_NEAR(double(t.transmitted->node(0, d, 0)), mu * std::exp(-tau / mu), 1e-5);
        }
        EXPECT_EQ(t.reflectedBelow[0], Rgb(0.0f));
    }
    // But a clear medium reflects inside.
    BaseVolume clear = homogeneous({1, 1, 2}, {1, 1, 1}, Rgb(0.0f), Rgb(0.0f));
    clear.ior.assign(2, 1.5f);
    const StfTable t = compute(clear, {});
    EXPECT_NEAR(double(t.reflectedBelow[0].x), 0.5963458, 0.01) << "F_int of index 1.5";
    EXPECT_NEAR(double(t.transmitted->node(0, 0, 0)), 0.96, 1e-4);
}

TEST(Precompute, OwnEmission) {
    // In the middle of a black, emitting medium the radiance is e / kappa from all sides.
    BaseVolume v = homogeneous({1, 1, 10}, {1, 1, 2}, Rgb(1.0f), Rgb(0.0f));
    v.emission.assign(10, Rgb(0.5f, 1.0f, 0.0f));
    TransportOptions options;
    options.quality = 0.005f;
    const StfTable t = compute(v, options);
    ASSERT_FALSE(t.emitted->empty());
    EXPECT_NEAR(double(t.emitted->node(5, 0, 0)) / (4 * kPi * 0.5), 1, 0.02);
    EXPECT_NEAR(double(t.emitted->node(5, 0, 1)) / (4 * kPi), 1, 0.02);
    EXPECT_EQ(t.emitted->node(5, 0, 2), 0);
    EXPECT_NEAR(double(t.emittedBelow[0].x) / (kPi * 0.5), 1, 0.02);
}

TEST(Precompute, SaysWhereItStaysAboveTheTarget) {
    const BaseVolume v = veined();
    std::vector<std::string> messages;
    const MessageSink sink = [&](Severity, const std::string& text) { messages.push_back(text); };
    TransportOptions options = quick();
    options.quality = 0.0005f;
    options.maxPhotons = 100000;
    const StfTable limited = compute(v, options, sink);
    EXPECT_GT(limited.error.total(), limited.error.target);
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_NE(messages[0].find("photons"), std::string::npos) << messages[0];
}

TEST(Precompute, CancelThrows) {
    for (double when : {0.0, 0.5}) {
        Progress* handle = nullptr;
        Progress progress([&](const std::string& stage, double fraction) {
            EXPECT_EQ(stage, "transport");
            if (fraction >= when) {
                handle->cancel();
            }
        });
        handle = &progress;
        EXPECT_THROW(precompute(relief(), quick(), progress, {}), Cancelled);
    }
    Progress before;
    before.cancel();
    EXPECT_THROW(precompute(relief(), quick(), before, {}), Cancelled);
}

TEST(Precompute, RefusesAnInvalidVolume) {
    BaseVolume v = relief();
    v.extinction[3].x = -1;
    EXPECT_THROW(compute(v, quick()), Error);
    v = relief();
    v.g.assign(v.voxelCount(), 1.0f);
    EXPECT_THROW(compute(v, quick()), Error) << "a delta lobe is no phase function";
}

TEST(Precompute, ExtremeNeighboursStayFinite) {
    BaseVolume v = relief();
    for (std::size_t i = 0; i < v.voxelCount(); i += 3) {
        v.extinction[i] = Rgb(i % 2 ? 1e6f : 0.0f, 1e-3f, 0.0f);
    }
    const StfTable t = compute(v, quick());
    EXPECT_TRUE(allFinite(t.multiple->factors));
    EXPECT_TRUE(allFinite(t.transmitted->factors));
    EXPECT_TRUE(allFinite(t.backlight->factors));
}

TEST(Precompute, KeyNamesEveryOption) {
    const TransportOptions plain;
    std::vector<TransportOptions> changed(8, plain);
    changed[0].quality = 0.01f;
    changed[1].seed = 1;
    changed[2].maxPhotons = 5;
    changed[3].polars = 3;
    changed[4].azimuths = 4;
    changed[5].form = TransportForm::Classic;
    changed[6].openBottom = true;
    changed[7].filter = false;
    for (const TransportOptions& o : changed) {
        EXPECT_NE(o.key(), plain.key());
    }
    EXPECT_EQ(plain.key(), TransportOptions().key());
}

} // namespace
