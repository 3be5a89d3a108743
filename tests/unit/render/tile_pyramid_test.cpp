// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/tile_pyramid.h"

#include "stfLib/base/random.h"
#include "stfLib/render/tile_march.h"
#include "stfLib/transport/precompute.h"
#include "tests/unit/support/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

// Columns of two media in random order; `contrast` is the ratio of their extinctions, `depth` the mean optical depth of
// a voxel.
BaseVolume twoMedia(float depth, float contrast) {
    BaseVolume v;
    v.size = {16, 16, 8};
    v.voxelMm = Vec3d(0.1);
    CounterRng rng(5, 1);
    std::vector<float> column(256);
    for (float& k : column) {
        k = rng.uniform() < 0.5f ? 1.0f : contrast;
    }
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.extinction.push_back(Rgb(column[i % 256] * depth / 0.1f / (0.5f * (1 + contrast))));
        v.albedo.push_back(Rgb(0.9f, 0.8f, 0.5f));
    }
    return v;
}

TilePyramid pyramid(const BaseVolume& v, double tolerance) {
    const auto medium = std::make_shared<const TileMedium>(v, TransportForm::DE1);
    TransportOptions options;
    options.quality = 0.05;
    Progress progress;
    const auto table = std::make_shared<const StfTable>(precompute(v, options, progress, {}));
    return {v, medium, table, false, tolerance};
}

// Mean radiance of the top, from random places and in directions that the pyramid's own measure does not use.
Estimate radiance(const TilePyramid::Level& level) {
    TileMarch march(*level.medium, *level.table);
    const Vec3f viewer = normalize(Vec3f(-0.2f, 0.5f, 0.7f));
    const MarchLight light{normalize(Vec3f(0.3f, 0.4f, 0.6f)), Rgb(1.0f), Rgb(1.0f)};
    const TileMedium& m = *level.medium;
    std::vector<double> values;
    for (int i = 0; i < 20000; ++i) {
        PixelSampler sampler(11, 3, std::uint32_t(i));
        const Vec2f at = sampler.next2d();
        march.begin(sampler);
        march.setFrame(&light, 1, viewer);
        march.segment(
            {at.x * float(m.size().x), at.y * float(m.size().y), 0},
            {float(-viewer.x / m.voxelMm().x), float(-viewer.y / m.voxelMm().y), float(viewer.z / m.voxelMm().z)},
            float(m.voxelMm().z * m.size().z) / viewer.z);
        const TileRadiance r = march.finish();
        values.push_back(double(average(r.single + r.multiple)));
    }
    return estimate(values);
}

TEST(TilePyramid, CoarseLevelsShineLikeTheTile) {
    const TilePyramid p = pyramid(twoMedia(0.1f, 1.6f), 0.02);
    ASSERT_GE(p.levels().size(), 3u) << p.why();
    const Estimate fine = radiance(p.levels()[0]);
    for (std::size_t l = 1; l < p.levels().size(); ++l) {
        const Estimate coarse = radiance(p.levels()[l]);
        EXPECT_LE(p.levels()[l].error, 0.02);
        EXPECT_NEAR(coarse.mean, fine.mean, 0.03 * fine.mean + 4 * std::hypot(coarse.sigma, fine.sigma)) << l;
        EXPECT_EQ(p.levels()[l].medium->size().x, 16 >> l);
    }
}

TEST(TilePyramid, EndsWhereMeansDoNotSayWhatIsSeen) {
    // Dense columns beside clear ones: a mean would hide the dense ones' light.
    const TilePyramid p = pyramid(twoMedia(1, 1000), 0.02);
    EXPECT_EQ(p.levels().size(), 1u);
    EXPECT_THAT(p.why(), ::testing::HasSubstr("would change its radiance"));
    EXPECT_EQ(p.bytes(), 0u);
}

TEST(TilePyramid, AUniformSampleNeedsNone) {
    const TilePyramid p = pyramid(twoMedia(0.1f, 1), 0.02);
    EXPECT_EQ(p.levels().size(), 1u);
    EXPECT_THAT(p.why(), ::testing::HasSubstr("the same everywhere"));
    EXPECT_EQ(p.levelFor(1e9f, 0.5f), 0);
}

TEST(TilePyramid, TheLevelFollowsTheFootprint) {
    const TilePyramid p = pyramid(twoMedia(0.1f, 3), 0.05);
    ASSERT_EQ(p.levels().size(), 4u) << p.why();
    EXPECT_EQ(p.levelFor(0, 0.5f), 0);
    EXPECT_EQ(p.levelFor(0.2f, 0.0f), 0);
    EXPECT_EQ(p.levelFor(std::nanf(""), 0.0f), 0);
    EXPECT_EQ(p.levelFor(0.401f, 0.9f), 1);
    EXPECT_EQ(p.levelFor(0.801f, 0.9f), 2);
    EXPECT_EQ(p.levelFor(1e20f, 0.9f), 3);
    EXPECT_EQ(p.levelFor(std::numeric_limits<float>::infinity(), 0.9f), 3);
    // In between both neighbours take their share.
    double sum = 0;
    for (int i = 0; i < 1000; ++i) {
        sum += p.levelFor(0.2f * std::sqrt(2.0f), (float(i) + 0.5f) / 1000);
    }
    EXPECT_NEAR(sum / 1000, 0.5, 2e-3);
}

} // namespace
} // namespace stf::test
