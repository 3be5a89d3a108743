// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/lane_walk.h"

#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

BaseVolume slab(double tau, double albedo, double g, double n = 1) {
    const BaseVolume v = homogeneous({1, 1, 1}, {1, 1, 1}, Rgb(float(tau)), Rgb(float(albedo)), float(g));
    return n == 1 ? v : withIndex(v, n);
}

// A column of layers of every kind, one of them void, one black.
BaseVolume layers() {
    BaseVolume v = homogeneous({1, 1, 6}, {3, 3, 0.5}, Rgb(1.0f), Rgb(0.9f));
    const float kappa[] = {0.5f, 0.5f, 0, 4, 1e-3f, 2}, albedo[] = {0.9f, 0.9f, 0.5f, 1, 0, 0.99f},
                g[] = {0, 0.7f, 0, -0.6f, 0.1f, 0.95f};
    for (std::size_t i = 0; i < 6; ++i) {
        v.extinction[i] = Rgb(kappa[i], 2 * kappa[i], 0.1f * kappa[i]);
        v.albedo[i] = Rgb(albedo[i], 0.5f * albedo[i], albedo[i]);
        v.g.resize(6);
        v.g[i] = g[i];
    }
    return v;
}

// Voxels all different, one in nine void, extinction different in each channel.
BaseVolume tile(double n = 1) {
    BaseVolume v = homogeneous({5, 3, 4}, {0.3, 0.5, 0.4}, Rgb(1.0f), Rgb(1.0f));
    CounterRng rng(11, 0);
    v.g.resize(v.voxelCount());
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const float k = i % 9 == 4 ? 0.0f : 5 * rng.uniform();
        v.extinction[i] = Rgb(k, 0.3f * k, 2 * k);
        v.albedo[i] = Rgb(rng.uniform(), 1, 0.9f);
        v.g[i] = 1.8f * rng.uniform() - 0.9f;
    }
    return n == 1 ? v : withIndex(v, n);
}

struct Numbers {
    double value, sigma;
};

// Totals of a tally with their errors, for all channels.
std::vector<Numbers> totals(const WalkTally& t) {
    std::vector<Numbers> all;
    for (int c = 0; c < 3; ++c) {
        const double n = double(t.photons);
        const double below = channelSum(t.below, c) + channelSum(t.belowUncollided, c);
        const double straight = channelSum(t.belowUncollided, c);
        all.push_back({t.above[c] / n, standardError(t.above[c], t.aboveSquared[c], t.photons)});
        all.push_back({below / n, standardError(below, t.belowSquared[c], t.photons)});
        all.push_back({t.absorbed[c] / n, standardError(t.absorbed[c], t.absorbedSquared[c], t.photons)});
        // Not squared by themselves: at most what a yes or no of probability p spreads.
        const auto atMost = [n](double p) { return Numbers{p, std::sqrt(p * std::max(0.0, 1 - p) / n)}; };
        all.push_back(atMost(straight / n));
        all.push_back(atMost(t.specular[c] / n));
    }
    return all;
}

void expectLikeScalar(const std::string& name, const BaseVolume& v, const WalkSource& source, bool openBottom = false,
                      std::uint64_t photons = 200'000) {
    SCOPED_TRACE(name);
    const TileMedium medium = trueMedium(v, openBottom);
    WalkRequest request = totalsRequest(photons, 5);
    ASSERT_TRUE(lanesCanWalk(medium, source, request));
    const WalkTally lanes = walkOnce(medium, source, request);
    request.scalar = true;
    request.seed = 6;
    const WalkTally scalar = walkOnce(medium, source, request);
    for (int c = 0; c < 3; ++c) {
        EXPECT_LT(imbalance(lanes, c), 1e-10);
    }
    const std::vector<Numbers> ours = totals(lanes), theirs = totals(scalar);
    double square = 0;
    int counted = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        const double sigma = std::hypot(ours[i].sigma, theirs[i].sigma);
        EXPECT_NEAR(ours[i].value, theirs[i].value, 4.5 * sigma + 1e-6) << "total " << i;
        if (sigma > 1e-7 && medium.channelLike(int(i) / 5) == int(i) / 5) {
            square += std::pow((ours[i].value - theirs[i].value) / sigma, 2);
            ++counted;
        }
    }
    // R + T + A = 1 makes them dependent: a generous bound, but one that a wrong formula breaks.
    EXPECT_LT(square, 4.5 * counted + 6);
    // Where light leaves, column by column.
    const std::size_t columns = lanes.below.size() / 3;
    double columnSquare = 0;
    for (std::size_t i = 0; i < columns && columns > 1; ++i) {
        const double a = lanes.below[3 * i], b = scalar.below[3 * i];
        columnSquare += (a - b) * (a - b) / std::max(1.0, a + b); // at least Poisson's where weights are at most 1
    }
    EXPECT_LT(columnSquare, 3.0 * double(columns) + 4);
    EXPECT_NEAR(double(lanes.collisions), double(scalar.collisions), 0.02 * double(scalar.collisions) + 50);
}

TEST(LaneWalk, AgreesWithSingleWalksInColumns) {
    expectLikeScalar("thin", slab(0.1, 0.7, 0.3), normalLight());
    expectLikeScalar("isotropic", slab(3, 0.9, 0), normalLight());
    expectLikeScalar("forward, oblique", slab(8, 0.99, 0.9), obliqueLight(0.3));
    expectLikeScalar("peaked", slab(30, 0.999, 0.99), normalLight());
    expectLikeScalar("backward", slab(4, 1, -0.8), obliqueLight(0.7));
    expectLikeScalar("black", slab(1, 0, 0), obliqueLight(0.5));
    expectLikeScalar("from below", slab(2, 0.8, 0.5), diffuse(WalkSource::Kind::DiffuseBelow));
    expectLikeScalar("layers", layers(), diffuse(WalkSource::Kind::DiffuseTop));
    expectLikeScalar("layers, normal", layers(), normalLight());
}

TEST(LaneWalk, AgreesWithSingleWalksBehindInterfaces) {
    expectLikeScalar("n 1.5", slab(2, 0.95, 0.6, 1.5), obliqueLight(0.4));
    expectLikeScalar("n 1.5, open", slab(2, 0.95, 0.6, 1.5), obliqueLight(0.4), true);
    expectLikeScalar("n 1.5, open, diffuse", slab(0.5, 1, 0, 1.5), diffuse(WalkSource::Kind::DiffuseTop), true);
    expectLikeScalar("n 1.5, open, below", slab(0.5, 0.9, 0, 1.5), diffuse(WalkSource::Kind::DiffuseBelow), true);
    expectLikeScalar("n 1.5, matched, below", slab(0.5, 0.9, 0, 1.5), diffuse(WalkSource::Kind::DiffuseBelow));
    expectLikeScalar("n 0.8", slab(2, 0.95, 0, 0.8), diffuse(WalkSource::Kind::DiffuseTop));
    expectLikeScalar("tile, n 1.4", tile(1.4), obliqueLight(0.6), true);
}

TEST(LaneWalk, AgreesWithSingleWalksInTiles) {
    expectLikeScalar("normal", tile(), normalLight());
    expectLikeScalar("oblique", tile(), obliqueLight(0.35));
    expectLikeScalar("diffuse", tile(), diffuse(WalkSource::Kind::DiffuseTop));
    expectLikeScalar("below", tile(), diffuse(WalkSource::Kind::DiffuseBelow));
}

TEST(LaneWalk, TheNumberOfVectorsDoesNotMatter) {
    for (const BaseVolume& v : {layers(), slab(2, 0.95, 0.6, 1.5), tile(), tile(1.4)}) {
        const TileMedium medium = trueMedium(v, true);
        const WalkRequest request = totalsRequest(10'000, 3);
        const Progress progress;
        const std::size_t columns = std::size_t(v.size.x) * std::size_t(v.size.y);
        const auto with = [&](LaneInstructions i) {
            WalkTally t;
            t.below.assign(3 * columns, 0);
            t.belowUncollided = t.belowUncollidedCosine = t.below;
            walkLanes(medium, obliqueLight(0.5), request, 0, t, progress, i);
            return t;
        };
        const WalkTally plain = with(LaneInstructions::Plain);
        EXPECT_GT(plain.collisions, 1000u);
        for (LaneInstructions i : {LaneInstructions::Avx2, LaneInstructions::Avx512}) {
            if (!available(i)) {
                continue;
            }
            const WalkTally t = with(i);
            EXPECT_EQ(t.above.x, plain.above.x);
            EXPECT_EQ(t.absorbed.x, plain.absorbed.x);
            EXPECT_EQ(t.belowSquared.x, plain.belowSquared.x);
            EXPECT_EQ(t.collisions, plain.collisions);
            EXPECT_EQ(t.below, plain.below);
        }
    }
}

TEST(LaneWalk, PartsOfTheWalksAddUpToTheWhole) {
    const TileMedium medium = trueMedium(tile());
    const WalkSource source = obliqueLight(0.5);
    WalkRequest request = totalsRequest(5000, 3);
    const WalkTally whole = walkOnce(medium, source, request);
    request.count = 1777;
    WalkTally parts = walkOnce(medium, source, request);
    request.first = 1777;
    request.count = 5000 - 1777;
    parts.add(walkOnce(medium, source, request));
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(parts.above[c], whole.above[c], 1e-9 * whole.above[c]);
        EXPECT_NEAR(parts.absorbed[c], whole.absorbed[c], 1e-9 * whole.absorbed[c] + 1e-9);
        EXPECT_NEAR(parts.belowSquared[c], whole.belowSquared[c], 1e-9 * whole.belowSquared[c]);
    }
    EXPECT_EQ(parts.collisions, whole.collisions);
}

TEST(LaneWalk, StiffSlabsKeepTheirBooks) {
    // albedo, optical thickness, g: what a float weight or depth would lose.
    const double cases[][3] = {{1, 1e-12, 0}, {1 - 1e-7, 1000, 0.9}, {1, 300, 0},
                               {0.5, 1e6, 0}, {0.9, 1e6, -0.999},    {0.99, 10, 0.999}};
    for (const auto& c : cases) {
        SCOPED_TRACE(testing::Message() << c[0] << " " << c[1] << " " << c[2]);
        const TileMedium medium = trueMedium(slab(c[1], c[0], c[2]));
        const WalkRequest request = totalsRequest(c[1] > 100 && c[0] > 0.999 ? 2000 : 20'000, 3);
        ASSERT_TRUE(lanesCanWalk(medium, normalLight(), request));
        const WalkTally t = walkOnce(medium, normalLight(), request);
        EXPECT_LT(imbalance(t), 1e-10);
        EXPECT_EQ(t.lost, 0u);
        if (c[0] == 1) {
            EXPECT_EQ(t.absorbed.x, 0);
        }
        if (c[1] == 1e-12) {
            EXPECT_EQ(t.collisions, 0u);
            EXPECT_NEAR(transmittedUncollided(t), 1, 1e-12);
        }
    }
}

TEST(LaneWalk, EveryPhotonStartsOnce) {
    // Fewer photons than lanes, none, and one more than fits evenly.
    const TileMedium medium = trueMedium(slab(1e-9, 1, 0));
    for (std::uint64_t photons : {0, 1, 63, 64, 65, 1000}) {
        const WalkTally t = walkOnce(medium, normalLight(), totalsRequest(photons, 3));
        EXPECT_DOUBLE_EQ(channelSum(t.belowUncollided, 0) + t.above.x + channelSum(t.below, 0), double(photons));
    }
}

TEST(LaneWalk, LeavesToSingleWalksWhatItCannotDo) {
    const WalkRequest request = totalsRequest(10);
    EXPECT_TRUE(lanesCanWalk(trueMedium(tile()), normalLight(), request));
    EXPECT_FALSE(lanesCanWalk(trueMedium(tile()), normalLight(), fluenceRequest(10)));
    WalkRequest other = request;
    other.analog = true;
    EXPECT_FALSE(lanesCanWalk(trueMedium(tile()), normalLight(), other));
    other = request;
    other.towardsViewer = {0, 0, 1};
    EXPECT_FALSE(lanesCanWalk(trueMedium(tile()), normalLight(), other));

    BaseVolume relief = tile();
    relief.surface.assign(relief.voxelCount(), -1.0f);
    relief.surface[0] = 0.1f;
    EXPECT_FALSE(lanesCanWalk(trueMedium(relief), normalLight(), request));
    BaseVolume indices = tile(1.3);
    indices.ior[3] = 1.4f;
    EXPECT_FALSE(lanesCanWalk(trueMedium(indices), normalLight(), request));
    // One voxel a million times denser: delta tracking would step through nothing.
    BaseVolume uneven = homogeneous({8, 8, 8}, {1, 1, 1}, Rgb(0.01f), Rgb(0.9f));
    uneven.extinction[5] = Rgb(1e4f);
    EXPECT_FALSE(lanesCanWalk(trueMedium(uneven), normalLight(), request));
    EXPECT_FALSE(lanesCanWalk(trueMedium(slab(0, 1, 0)), normalLight(), request));
}

TEST(LaneWalk, IsCancelled) {
    Progress progress;
    progress.cancel();
    EXPECT_THROW(walk(trueMedium(slab(1000, 1, 0)), normalLight(), totalsRequest(100'000'000), progress), Cancelled);
}

} // namespace
