// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/tile_tracer.h"

#include "stfLib/base/random.h"

#include <gtest/gtest.h>
#include <vector>

using namespace stf;

namespace {

struct Piece {
    int index, x, y, z;
    float t0, t1;
};

std::vector<Piece> trace(const Vec3i& size, const Vec3f& p, const Vec3f& d, float tMax = 1e6f, float* end = nullptr) {
    std::vector<Piece> pieces;
    const float t = TileTracer(size).traverse(p, d, tMax, [&](int i, int x, int y, int z, float t0, float t1) {
        pieces.push_back({i, x, y, z, t0, t1});
        return true;
    });
    if (end) {
        *end = t;
    }
    return pieces;
}

TEST(TileTracer, PiecesAddUpAndEachLiesInItsVoxel) {
    const Vec3i size(4, 3, 5);
    CounterRng rng(3, 0);
    for (int i = 0; i < 2000; ++i) {
        // Far positions on both sides of zero wrap.
        const Vec3f p{40 * rng.uniform() - 20, 40 * rng.uniform() - 20, 5 * rng.uniform()};
        const Vec3f d{rng.uniform() - 0.5f, rng.uniform() - 0.5f, rng.uniform() - 0.5f};
        float end = 0, t = 0;
        for (const Piece& s : trace(size, p, d, 1e6f, &end)) {
            ASSERT_EQ(s.t0, t) << "no gap, no overlap";
            ASSERT_GT(s.t1, s.t0);
            ASSERT_EQ(s.index, s.x + 4 * (s.y + 3 * s.z));
            const Vec3f middle = p + d * (0.5f * (s.t0 + s.t1));
            const float e = 1e-3f; // of a position some 100 voxels away
            if (s.t1 - s.t0 > 2 * e && s.t1 < 200) {
                const float x = middle.x - 4 * std::floor(middle.x / 4), y = middle.y - 3 * std::floor(middle.y / 3);
                const auto inside = [&](float c, int cell, float n) {
                    const float distance = std::abs(c - (float(cell) + 0.5f));
                    return std::min(distance, n - distance) <= 0.5f + e;
                };
                ASSERT_TRUE(inside(x, s.x, 4) && inside(y, s.y, 3) && inside(middle.z, s.z, 1e9f)) << i;
            }
            t = s.t1;
        }
        ASSERT_EQ(end, t);
        if (std::abs(d.z) > 1e-3f) {
            ASSERT_NEAR(p.z + d.z * t, d.z > 0 ? 5 : 0, 2e-3f);
        }
    }
}

TEST(TileTracer, LengthsPerVoxelAgreeWithSampling) {
    const Vec3i size(4, 3, 5);
    const Vec3f p{0.3f, 2.9f, 0}, d = normalize(Vec3f(0.7f, -0.45f, 0.3f));
    std::vector<double> lengths(60, 0.0), sampled(60, 0.0);
    float end = 0;
    for (const Piece& s : trace(size, p, d, 1e6f, &end)) {
        lengths[std::size_t(s.index)] += double(s.t1 - s.t0);
    }
    const int n = 400000;
    for (int i = 0; i < n; ++i) {
        const double t = (i + 0.5) / n * double(end);
        const Vec3d q = Vec3d(p) + Vec3d(d) * t;
        sampled[std::size_t(TileTracer::wrap(int(std::floor(q.x)), 4) +
                            4 * (TileTracer::wrap(int(std::floor(q.y)), 3) + 3 * std::min(4, int(q.z))))] +=
            double(end) / n;
    }
    for (std::size_t i = 0; i < 60; ++i) {
        EXPECT_NEAR(lengths[i], sampled[i], 3e-4);
    }
    EXPECT_NEAR(end, 5 / d.z, 1e-4f);
}

TEST(TileTracer, AxisParallel) {
    const Vec3i size(4, 3, 5);
    const auto down = trace(size, {1.5f, 2.5f, 0}, {0, 0, 1});
    ASSERT_EQ(down.size(), 5u);
    EXPECT_EQ(down[4].z, 4);
    EXPECT_EQ(down[4].t1, 5);
    const auto up = trace(size, {1.5f, 2.5f, 5}, {0, 0, -2});
    ASSERT_EQ(up.size(), 5u);
    EXPECT_EQ(up[0].z, 4);
    EXPECT_EQ(up[4].t1, 2.5f) << "t is in the caller's unit";
    // Sideways it never leaves: it ends where it was told to.
    float end = 0;
    const auto side = trace(size, {0.5f, 0.5f, 2.5f}, {-1, 0, 0}, 10, &end);
    EXPECT_EQ(end, 10);
    ASSERT_EQ(side.size(), 11u);
    EXPECT_EQ(side[1].x, 3);
    EXPECT_EQ(side[4].x, 0);
    EXPECT_EQ(side.back().t1, 10);
}

TEST(TileTracer, StartsOnFaces) {
    const Vec3i size(4, 3, 5);
    EXPECT_EQ(trace(size, {2, 1.5f, 2.5f}, {1, 0, 0.1f})[0].x, 2);
    EXPECT_EQ(trace(size, {2, 1.5f, 2.5f}, {-1, 0, 0.1f})[0].x, 1);
    EXPECT_EQ(trace(size, {0, 1.5f, 2.5f}, {-1, 0, 0.1f})[0].x, 3) << "wraps";
    EXPECT_EQ(trace(size, {4, 1.5f, 2.5f}, {1, 0, 0.1f})[0].x, 0) << "wraps";
    EXPECT_EQ(trace(size, {1.5f, 1.5f, 3}, {0, 0, 1})[0].z, 3);
    EXPECT_EQ(trace(size, {1.5f, 1.5f, 3}, {0, 0, -1})[0].z, 2);
    // Outward from top and bottom there is nothing.
    float end = 1;
    EXPECT_TRUE(trace(size, {1.5f, 1.5f, 0}, {0, 0.3f, -1}, 1e6f, &end).empty());
    EXPECT_EQ(end, 0);
    EXPECT_TRUE(trace(size, {1.5f, 1.5f, 5}, {0, 0.3f, 1}, 1e6f, &end).empty());
    EXPECT_EQ(end, 0);
    // Along an edge of voxels, every piece still has a length.
    for (const Piece& s : trace(size, {1, 1, 0}, {1, 1, 1})) {
        EXPECT_GT(s.t1, s.t0);
    }
}

TEST(TileTracer, OneColumn) {
    const Vec3f d = normalize(Vec3f(5, -3, 1));
    float end = 0;
    std::vector<double> lengths(4, 0.0);
    for (const Piece& s : trace({1, 1, 4}, {-7.3f, 0.2f, 0}, d, 1e6f, &end)) {
        ASSERT_EQ(s.index, s.z);
        lengths[std::size_t(s.z)] += double(s.t1 - s.t0);
    }
    EXPECT_NEAR(end, 4 / d.z, 1e-4f);
    for (double l : lengths) {
        EXPECT_NEAR(l, 1 / double(d.z), 1e-4);
    }
}

TEST(TileTracer, StopsWhenTold) {
    int visits = 0;
    const float end =
        TileTracer({4, 3, 5}).traverse({0.5f, 0.5f, 0}, {0, 0, 1}, 1e6f, [&](int, int, int, int z, float, float) {
            ++visits;
            return z < 2;
        });
    EXPECT_EQ(visits, 3);
    EXPECT_EQ(end, 2) << "where the last voxel was entered";
    EXPECT_EQ(trace({4, 3, 5}, {0.5f, 0.5f, 0}, {0, 0, 1}, 2.5f).back().t1, 2.5f);
}

TEST(TileTracer, Wrap) {
    EXPECT_EQ(TileTracer::wrap(-1, 4), 3);
    EXPECT_EQ(TileTracer::wrap(-4, 4), 0);
    EXPECT_EQ(TileTracer::wrap(9, 4), 1);
    EXPECT_EQ(TileTracer::wrap(-5, 1), 0);
}

} // namespace
