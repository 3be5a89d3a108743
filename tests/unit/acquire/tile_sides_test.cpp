// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/periodicity.h"
#include "stfLib/acquire/tile_blend.h"
#include "stfLib/acquire/tile_quilt.h"
#include "stfLib/base/random.h"
#include "tests/unit/support/files.h"

#include <cmath>
#include <set>

using namespace stf;
using namespace stf::test;

namespace {

// Blobs of two materials in a void, not periodic; soft or of pure voxels.
TileField blobs(const Vec3i& size, bool pure, std::uint64_t seed) {
    TileField f;
    f.size = size;
    f.materials = 2;
    CounterRng rng(seed, 0);
    double k[8][4];
    for (auto& wave : k) {
        for (int a = 0; a < 3; ++a) {
            wave[a] = 0.9 * double(rng.uniform()) - 0.45;
        }
        wave[3] = 6.28 * double(rng.uniform());
    }
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                double v = 0;
                for (const auto& w : k) {
                    v += std::sin(w[0] * x + w[1] * y + w[2] * z + w[3]);
                }
                double a = std::clamp(v / 2 + 0.5, 0.0, 1.0), b = (1 - a) * std::clamp(-v / 2, 0.0, 1.0);
                if (pure) {
                    a = a > 0.5 ? 1 : 0;
                    b = a == 0 && v < -1 ? 1 : 0;
                }
                f.fractions.push_back(float(a));
                f.fractions.push_back(float(b));
                f.level.push_back(float(0.5 - a));
            }
        }
    }
    return f;
}

TEST(Periodicity, KnownNumbers) {
    // A ramp along x: neighbours differ by 1/7, the sides by 1; nothing along y.
    TileField f;
    f.size = {8, 5, 3};
    f.materials = 1;
    for (int i = 0; i < 8 * 15; ++i) {
        f.fractions.push_back(float(i % 8) / 7);
    }
    const PeriodicityError e = periodicityError(f);
    EXPECT_NEAR(e.x, 7, 1e-5);
    EXPECT_EQ(e.y, 0);
    EXPECT_NEAR(neighbourDifference(f, 0), 1.0 / 7, 1e-6);
    // Content that changes for another counts once, as does content that changes for a void.
    const float a[2] = {1, 0}, b[2] = {0, 1}, none[2] = {0, 0}, half[2] = {0.5, 0};
    EXPECT_EQ(contentDifference(a, b, 2), 1);
    EXPECT_EQ(contentDifference(a, none, 2), 1);
    EXPECT_EQ(contentDifference(a, half, 2), 0.5f);
}

TEST(BlendSides, KeepsMeansAndFits) {
    for (std::uint64_t seed : {1, 2, 3}) {
        const TileField f = blobs({40, 36, 10}, false, seed), tile = blendSides(f, {10, 12, 0});
        EXPECT_EQ(tile.size, f.size);
        const auto before = meanFractions(f), after = meanFractions(tile);
        EXPECT_NEAR(after[0], before[0], 1e-6);
        EXPECT_NEAR(after[1], before[1], 1e-6);
        const PeriodicityError was = periodicityError(f), is = periodicityError(tile);
        EXPECT_GT(was.x, 1.5);
        EXPECT_GT(was.y, 1.5);
        EXPECT_LT(is.x, 1);
        EXPECT_LT(is.y, 1);
        for (std::size_t i = 0; i < tile.voxelCount(); ++i) {
            ASSERT_GE(tile.at(i)[0], 0);
            ASSERT_LE(tile.at(i)[0] + tile.at(i)[1], 1 + 1e-5f);
        }
        // The middle stays what it is.
        EXPECT_EQ(tile.at(tile.index(20, 18, 5))[0], f.at(f.index(20, 18, 5))[0]);
    }
    EXPECT_THROW(blendSides(blobs({10, 10, 2}, false, 1), {6, 2, 0}), Error);
    EXPECT_THROW(blendSides(blobs({10, 10, 2}, false, 1), {2, 0, 0}), Error);
}

TEST(QuiltSides, FitsAndStaysSharp) {
    Progress progress;
    double before = 0, cuts = 0;
    for (std::uint64_t seed : {1, 2, 3, 4}) {
        const TileField f = blobs({48, 44, 8}, true, seed);
        const QuiltedTile q = quiltSides(f, {14, 12, 0}, progress);
        EXPECT_EQ(q.tile.size, Vec3i(34, 32, 8));
        const PeriodicityError was = periodicityError(f), is = periodicityError(q.tile);
        std::printf("             sides %.2f %.2f before, %.2f %.2f after, cuts %.2f %.2f\n", was.x, was.y, is.x, is.y,
                    q.cutX, q.cutY);
        EXPECT_LT(is.x, 1.8);
        EXPECT_LT(is.y, 1.8);
        before += was.x + was.y;
        cuts += q.cutX + q.cutY;
        for (const float v : q.tile.fractions) { // every voxel is one of the field's
            ASSERT_TRUE(v == 0 || v == 1);
        }
        for (std::size_t i = 0; i < q.tile.voxelCount(); ++i) { // with its own level
            ASSERT_EQ(q.tile.level[i], 0.5f - q.tile.at(i)[0]);
        }
    }
    EXPECT_LT(cuts, 0.6 * before);
    EXPECT_THROW(quiltSides(blobs({10, 10, 2}, true, 1), {1, 2, 0}, progress), Error);
    EXPECT_THROW(quiltSides(blobs({10, 10, 2}, true, 1), {2, 6, 0}, progress), Error);
}

// What repeats already, with a period that is the tile's after cutting, is cut without a trace.
TEST(QuiltSides, LeavesNoTraceInWhatRepeats) {
    TileField f;
    f.size = {40, 30, 4};
    f.materials = 1;
    for (int z = 0; z < 4; ++z) {
        for (int y = 0; y < 30; ++y) {
            for (int x = 0; x < 40; ++x) {
                f.fractions.push_back(((x % 32) * 7 + (y % 24) * 5 + z) % 11 < 4 ? 1.0f : 0.0f);
            }
        }
    }
    Progress progress;
    const QuiltedTile q = quiltSides(f, {8, 6, 0}, progress);
    for (int z = 0; z < 4; ++z) {
        for (int y = 0; y < 24; ++y) {
            for (int x = 0; x < 32; ++x) {
                ASSERT_EQ(q.tile.at(q.tile.index(x, y, z))[0], f.at(f.index(x, y, z))[0]);
            }
        }
    }
    EXPECT_NEAR(q.cutX, 1, 0.35);
}

} // namespace
