// SPDX-License-Identifier: Apache-2.0
// What is made finer to measure errors: it comes nearer to the limit, or leaves the picture as it is where there is
// nothing to come nearer to.
#include "stfLib/render/exactness.h"

#include "tests/unit/render/slab_fixture.h"

#include <cmath>

namespace stf::test {
namespace {

// The table that a slab is rendered with, and its picture.
struct Pictured {
    std::shared_ptr<const StfTable> table;
    std::vector<float> color;
};

Pictured pictured(Slab slab, const char* exact) {
    Pictured out;
    slab.settings.exact = Exactness::parse(exact);
    slab.tables = [&](const std::shared_ptr<const BaseVolume>& volume, const TransportOptions& options,
                      Progress& progress, const MessageSink& sink) {
        return out.table = Slab::sharedTables(volume, options, progress, sink);
    };
    out.color = slab.render();
    return out;
}

double largest(const std::vector<float>& values) {
    return double(*std::max_element(values.begin(), values.end()));
}

double largestDifference(const std::vector<float>& a, const std::vector<float>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        most = std::max(most, std::abs(double(a[i]) - double(b[i])));
    }
    return most;
}

// Stripes of two albedos, a voxel wide.
void stripes(BaseVolume& v) {
    const BaseVolume column = v;
    v.size = {8, 8, column.size.z};
    v.extinction.assign(v.voxelCount(), column.extinction[0]);
    v.albedo.resize(v.voxelCount());
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.albedo[i] = Rgb(i % 2 ? 0.9f : 0.2f);
    }
    v.g.clear();
}

TEST(Exactness, NamesInAnyOrder) {
    EXPECT_EQ(Exactness::parse(""), Exactness());
    const Exactness two = Exactness::parse("voxels,levels");
    EXPECT_TRUE(two.voxels && two.levels);
    EXPECT_FALSE(two.step || two.coreTree || two.directions);
    EXPECT_EQ(Exactness::parse("levels,voxels"), two);
    EXPECT_THROW(Exactness::parse("levels,stairs"), Error);
    EXPECT_THROW(Exactness::parse("levels, voxels"), Error);
}

TEST(Exactness, HalvedVoxelsComeNearerToFineOnes) {
    // Optical depth 3 in three voxels: light kept for a voxel is far from what it is at its top and bottom.
    Slab slab;
    slab.tau = 3;
    slab.settings.samples = 256;
    slab.quality = 0.004f;
    const auto radiance = [&](int layersPerMm, const char* exact) {
        slab.layersPerMm = layersPerMm;
        slab.settings.exact = Exactness::parse(exact);
        return slab.radiance();
    };
    const Slab::Measured coarse = radiance(1, ""), halved = radiance(1, "voxels"), fine = radiance(16, "");
    const double off = std::abs(coarse.mean - fine.mean), left = std::abs(halved.mean - fine.mean);
    const double noise = 4 * std::hypot(coarse.error, fine.error) + (coarse.table + fine.table) * fine.mean;
    ASSERT_GT(off, noise) << "the voxels are coarse enough to tell";
    EXPECT_LT(left, 0.5 * off + noise);

    Slab three;
    three.layersPerMm = 1;
    three.tau = 3;
    EXPECT_EQ(pictured(three, "").table->size, Vec3i(1, 1, 3));
    EXPECT_EQ(pictured(three, "voxels").table->size.z, 6);
}

TEST(Exactness, ReliefsKeepTheirVoxels) {
    Slab slab;
    slab.relief = true;
    slab.quality = 0.2f;
    slab.settings.samples = 1;
    slab.settings.exact.voxels = true;
    slab.render();
    ASSERT_EQ(slab.messages.size(), 1u);
    EXPECT_NE(slab.messages[0].find("stf:exact: voxels: a sample with a relief"), std::string::npos)
        << slab.messages[0];
}

TEST(Exactness, MoreDirectionsHaveASmallerError) {
    Slab slab;
    slab.quality = 0.05f;
    slab.settings.samples = 1;
    const Pictured usual = pictured(slab, ""), finer = pictured(slab, "directions");
    EXPECT_GT(finer.table->directions.count(), usual.table->directions.count());
    EXPECT_LT(finer.table->error.directions, 0.6 * usual.table->error.directions);
}

TEST(Exactness, AFinerMarchOfAFlatShellIsTheSame) {
    Slab slab;
    slab.viewCosine = 0.5;
    slab.settings.samples = 64;
    const Slab::Measured usual = slab.radiance();
    slab.settings.exact.step = true;
    const Slab::Measured finer = slab.radiance();
    EXPECT_NE(usual.mean, finer.mean) << "it takes other steps";
    // Where single scattering is asked for is drawn along the way: other steps, other noise.
    EXPECT_NEAR(usual.mean, finer.mean, 4 * std::hypot(usual.error, finer.error));
    EXPECT_LT(std::hypot(usual.error, finer.error), 0.003 * usual.mean);
}

TEST(Exactness, CoarserLevelsAreLeftOutWherePixelsAskForThem) {
    Slab slab;
    slab.quality = 0.1f;
    slab.shape = stripes;
    slab.settings.samples = 16;
    const std::vector<float> near = pictured(slab, "").color;
    EXPECT_EQ(pictured(slab, "levels").color, near) << "pixels as fine as voxels ask for none";
    slab.viewMm = 8;
    slab.settings.samples = 256;
    const std::vector<float> far = pictured(slab, "").color, finest = pictured(slab, "levels").color;
    EXPECT_NE(far, finest);
    double mean = 0, other = 0;
    for (std::size_t i = 1; i < far.size(); i += 4) {
        mean += double(far[i]);
        other += double(finest[i]);
    }
    EXPECT_NEAR(mean, other, 0.02 * other) << "coarser levels are made to show the same";
}

TEST(Exactness, FinerSumsOverTheCoreAreCloseToTheUsual) {
    Slab slab;
    slab.coreAlbedo = 0.95;
    slab.quality = 0.1f;
    slab.shape = stripes; // under even light any sums would do
    slab.settings.samples = 4;
    const std::vector<float> usual = pictured(slab, "").color, finer = pictured(slab, "coreTree").color;
    EXPECT_NE(usual, finer);
    // What trees are off by is a fiftieth of their bound of .5 (CoreResponse::kEpsilon); half of the light is the
    // core's.
    EXPECT_LT(largestDifference(usual, finer), 0.01 * largest(usual));
}

} // namespace
} // namespace stf::test
