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

TransportOptions quick(std::uint64_t seed = 0, std::uint64_t photons = 4000) {
    TransportOptions options;
    options.seed = seed;
    options.maxPhotons = photons;
    options.polars = 3;
    return options;
}

// A tile with a void, so that azimuths matter.
BaseVolume relief() {
    BaseVolume v = homogeneous({4, 3, 4}, {1, 1, 1}, Rgb(0.8f), Rgb(0.9f, 0.8f, 0.7f), 0.3f);
    v.extinction[v.index(1, 1, 0)] = Rgb(0.0f);
    return v;
}

void expectSame(const StfTable& a, const StfTable& b) {
    EXPECT_TRUE(a.multiple == b.multiple);
    EXPECT_TRUE(a.backlight == b.backlight);
    EXPECT_TRUE(a.transmitted == b.transmitted);
    EXPECT_TRUE(a.direct == b.direct);
    EXPECT_TRUE(a.reflectedBelow == b.reflectedBelow);
    EXPECT_EQ(a.photonsPerDirection, b.photonsPerDirection);
    EXPECT_EQ(a.relativeError, b.relativeError);
}

TEST(Precompute, DoesNotDependOnThreads) {
    setThreadCount(1);
    const StfTable one = compute(relief(), quick());
    setThreadCount(2);
    const StfTable two = compute(relief(), quick());
    setThreadCount(0);
    expectSame(one, two);
    EXPECT_FALSE(one.multiple == compute(relief(), quick(1)).multiple) << "another seed";
}

TEST(Precompute, ShapeOfTheTable) {
    const StfTable t = compute(relief(), quick());
    EXPECT_EQ(t.size, Vec3i(4, 3, 4));
    EXPECT_EQ(t.directions.count(), 3 * 6) << "six azimuths where there is relief";
    EXPECT_EQ(t.multiple.size(), 48u * 18 * 3);
    EXPECT_EQ(t.transmitted.size(), 12u * 18 * 3);
    EXPECT_EQ(t.direct.size(), t.transmitted.size());
    EXPECT_EQ(t.backlight.size(), 48u);
    EXPECT_EQ(t.reflectedBelow.size(), 12u);
    EXPECT_EQ(t.volumeHash, relief().contentHash());
    EXPECT_GT(t.bytes(), 48u * 18 * 3 * 4);
    for (std::size_t i = 0; i < t.transmitted.size(); ++i) {
        ASSERT_GE(t.transmitted[i], t.direct[i]);
    }
    for (float m : t.multiple) {
        ASSERT_TRUE(std::isfinite(m) && m >= 0);
    }
}

TEST(Precompute, HomogeneousTileIsOneColumn) {
    const BaseVolume one = homogeneous({1, 1, 6}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    const BaseVolume many = homogeneous({5, 4, 6}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    const StfTable a = compute(one, quick()), b = compute(many, quick());
    EXPECT_EQ(b.size, Vec3i(1, 1, 6));
    expectSame(a, b);
    EXPECT_NE(a.volumeHash, b.volumeHash);
}

TEST(Precompute, ColumnsOfAHomogeneousTileAgreeWithOneColumn) {
    // A difference too small to matter makes the tile go the long way.
    const BaseVolume one = homogeneous({1, 1, 4}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    BaseVolume many = homogeneous({4, 3, 4}, {0.5, 0.5, 0.5}, Rgb(1.0f), Rgb(0.9f));
    many.albedo[0] = Rgb(0.9f + 1e-6f);
    ASSERT_FALSE(many.laterallyUniform());
    std::vector<StfTable> a, b;
    for (std::uint64_t k = 0; k < 32; ++k) {
        TransportOptions options = quick(k, 4000);
        options.quality = 1e-6f;
        a.push_back(compute(one, options));
        options.seed += 1000;
        b.push_back(compute(many, options));
        ASSERT_EQ(b.back().size, Vec3i(4, 3, 4));
        ASSERT_EQ(b.back().directions.azimuths(), 1) << "flat: averaged over azimuth";
    }
    const auto expectEqual = [&](const Estimate& x, const Estimate& y) {
        const double sigma = std::hypot(x.sigma, y.sigma);
        EXPECT_LT(sigma, 0.02 * y.mean);
        EXPECT_LE(std::abs(x.mean - y.mean), 4 * sigma);
    };
    for (int d = 0; d < 3; ++d) {
        for (std::size_t z = 0; z < 4; ++z) {
            const auto im = [&](std::size_t voxel) {
                return [=](const StfTable& t) { return double(t.multiple[(voxel * 3 + std::size_t(d)) * 3]); };
            };
            const Estimate reference = estimate(a, im(z));
            for (std::size_t column : {0, 5, 11}) {
                expectEqual(estimate(b, im(column + 12 * z)), reference);
            }
        }
        const auto transmitted = [&](std::size_t column) {
            return [=](const StfTable& t) { return double(t.transmitted[(column * 3 + std::size_t(d)) * 3]); };
        };
        expectEqual(estimate(b, transmitted(7)), estimate(a, transmitted(0)));
    }
    const auto back = [](std::size_t voxel) { return [=](const StfTable& t) { return double(t.backlight[voxel].x); }; };
    expectEqual(estimate(b, back(17)), estimate(a, back(1)));
    expectEqual(estimate(b, [](const StfTable& t) { return double(t.reflectedBelow[3].x); }),
                estimate(a, [](const StfTable& t) { return double(t.reflectedBelow[0].x); }));
}

TEST(Precompute, WithoutScatteringNoDirectionIsWalked) {
    for (const Rgb& extinction : {Rgb(0.7f), Rgb(0.0f)}) {
        // The albedo of an empty tile does not matter.
        const Rgb albedo(extinction.x > 0 ? 0.0f : 0.9f);
        TransportOptions options = quick();
        options.maxPhotons = 100000; // of the backlight, which is walked even so
        const StfTable t = compute(homogeneous({1, 1, 4}, {1, 1, 0.5}, extinction, albedo), options);
        EXPECT_EQ(t.photonsPerDirection, 0u);
        EXPECT_EQ(t.relativeError, 0);
        for (float m : t.multiple) {
            ASSERT_EQ(m, 0);
        }
        const double tau = 2 * double(extinction.x);
        for (int d = 0; d < 3; ++d) {
            const double mu = double(t.directions.direction(d).z);
            EXPECT_NEAR(double(t.transmitted[std::size_t(d) * 3]), mu * std::exp(-tau / mu), 1e-6);
            EXPECT_EQ(t.transmitted[std::size_t(d) * 3], t.direct[std::size_t(d) * 3]);
        }
        EXPECT_EQ(t.reflectedBelow[0], Rgb(0.0f));
        for (int z = 0; z < 4; ++z) {
            // Mean over the layer of 2 pi E2(optical depth from below); 20000 walks: 1 % of noise.
            double expected = 0;
            for (int i = 0; i < 16; ++i) {
                expected += 2 * kPi * expIntegral(2, tau * (4 - z - (i + 0.5) / 16) / 4) / 16;
            }
            EXPECT_NEAR(double(t.backlight[std::size_t(z)].x) / expected, 1, 0.05) << z;
        }
    }
}

TEST(Precompute, MeetsItsTargetOrSaysSo) {
    const BaseVolume v = homogeneous({1, 1, 8}, {1, 1, 0.5}, Rgb(1.0f), Rgb(0.9f));
    std::vector<std::string> messages;
    const MessageSink sink = [&](Severity, const std::string& text) { messages.push_back(text); };
    TransportOptions options;
    options.polars = 2;
    options.quality = 0.02f;
    const StfTable good = compute(v, options, sink);
    EXPECT_LE(good.relativeError, 1.3 * 2 * 0.02);
    EXPECT_TRUE(messages.empty());
    options.quality = 0.0002f;
    options.maxPhotons = 8000;
    const StfTable limited = compute(v, options, sink);
    EXPECT_EQ(limited.photonsPerDirection, 8000u);
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_NE(messages[0].find("8000 photons"), std::string::npos) << messages[0];
}

TEST(Precompute, RelativeErrorIsTheScatterOverSeeds) {
    // The estimate from batches within one table, against the scatter of tables: both good to some 10 %.
    const BaseVolume v = homogeneous({1, 1, 8}, {1, 1, 0.5}, Rgb(1.0f), Rgb(0.9f));
    std::vector<StfTable> all;
    for (std::uint64_t k = 0; k < 32; ++k) {
        TransportOptions options = quick(k);
        options.quality = 1e-6f;
        options.polars = 1;
        all.push_back(compute(v, options));
    }
    double variance = 0, mean = 0, estimated = 0;
    for (std::size_t z = 0; z < 8; ++z) {
        const Estimate e = estimate(all, [&](const StfTable& t) { return double(t.multiple[z * 3]); });
        variance += e.sigma * e.sigma * 32;
        mean += e.mean * e.mean;
    }
    for (const StfTable& t : all) {
        estimated += t.relativeError * t.relativeError / 32;
    }
    EXPECT_NEAR(std::sqrt(estimated) / std::sqrt(variance / mean), 1, 0.35);
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
}

TEST(Precompute, ExtremeNeighboursStayFinite) {
    BaseVolume v = relief();
    for (std::size_t i = 0; i < v.voxelCount(); i += 3) {
        v.extinction[i] = Rgb(i % 2 ? 1e6f : 0.0f, 1e-3f, 0.0f);
    }
    const StfTable t = compute(v, quick(0, 2000));
    for (float m : t.multiple) {
        ASSERT_TRUE(std::isfinite(m) && m >= 0);
    }
    for (float m : t.transmitted) {
        ASSERT_TRUE(std::isfinite(m) && m >= 0);
    }
    for (const Rgb& b : t.backlight) {
        ASSERT_TRUE(isFinite(b) && minComponent(b) >= 0);
    }
}

TEST(Precompute, KeyNamesEveryOption) {
    const TransportOptions plain;
    TransportOptions quality = plain, seed = plain, photons = plain, polars = plain, azimuths = plain;
    quality.quality = 0.01f;
    seed.seed = 1;
    photons.maxPhotons = 5;
    polars.polars = 3;
    azimuths.azimuths = 4;
    for (const TransportOptions& o : {quality, seed, photons, polars, azimuths}) {
        EXPECT_NE(o.key(), plain.key());
    }
    EXPECT_EQ(plain.key(), TransportOptions().key());
}

} // namespace
