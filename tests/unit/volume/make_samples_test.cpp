// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/make_samples.h"

#include "stfLib/optics/property_table.h"
#include "stfLib/volume/volume_statistics.h"
#include "tests/unit/support/files.h"

using namespace stf;
using namespace stf::test;

namespace {

BaseVolume sample(const std::string& name, std::uint32_t seed = 0, Vec3i size = {0, 0, 0}) {
    SampleOptions options;
    options.seed = seed;
    options.size = size;
    return makeSample(name, options);
}

TEST(MakeSample, AllNames) {
    ASSERT_GE(sampleNames().size(), 3u);
    for (const SampleInfo& info : sampleNames()) {
        EXPECT_FALSE(info.description.empty());
        const BaseVolume v = sample(info.name);
        EXPECT_NO_THROW(validate(v)) << info.name;
        EXPECT_EQ(v.name, info.name);
        EXPECT_TRUE(v.hasCore()) << info.name;
        EXPECT_EQ(v.contentHash(), sample(info.name).contentHash()) << info.name;
        const BaseVolume small = sample(info.name, 0, {8, 8, 4});
        EXPECT_EQ(small.size, Vec3i(8, 8, 4));
        EXPECT_NO_THROW(validate(small));
    }
}

TEST(MakeSample, UnknownNameTellsTheKnownOnes) {
    const std::string text = messageOf<Error>([] { sample("granite"); });
    EXPECT_NE(text.find("granite"), std::string::npos);
    for (const SampleInfo& info : sampleNames()) {
        EXPECT_NE(text.find(info.name), std::string::npos) << text;
    }
}

TEST(MakeSample, AbsurdSize) {
    EXPECT_THROW(sample("marble", 0, {100000, 100000, 100}), Error);
    EXPECT_THROW(sample("wax", 0, {-1, 8, 8}), Error);
    EXPECT_THROW(sample("uniform", 0, {0, 0, 5}), Error);
}

TEST(MakeSample, RandomHasItsMeanAndRange) {
    SampleOptions options;
    options.size = {16, 12, 8};
    options.voxelMm = 0.5;
    options.ratio = 30;
    options.tau = 7;
    options.g = 0.5f;
    const BaseVolume v = makeSample("random", options);
    double sum = 0;
    float lowest = 1e30f, highest = 0;
    for (const Rgb& k : v.extinction) {
        EXPECT_EQ(k.x, k.z);
        sum += double(k.x);
        lowest = std::min(lowest, k.x);
        highest = std::max(highest, k.x);
    }
    EXPECT_NEAR(sum / double(v.voxelCount()) * v.extentMm().z, 7, 1e-4);
    EXPECT_LE(highest / lowest, 30.001f);
    EXPECT_GE(highest / lowest, 28.0f);
    EXPECT_EQ(v.g[5], 0.5f);
    EXPECT_NE(v.contentHash(), sample("random", 1, {16, 12, 8}).contentHash());
    options.ratio = 0.5;
    EXPECT_THROW(makeSample("random", options), Error);
}

TEST(MakeSample, SeedChangesMarble) {
    EXPECT_NE(sample("marble", 1, {16, 16, 4}).contentHash(), sample("marble", 2, {16, 16, 4}).contentHash());
}

// Voxels that meet where tiles join differ no more than neighbours inside do.
TEST(MakeSample, Periodic) {
    for (const std::string name : {"marble", "jade", "skin", "coral", "ice", "wax"}) {
        for (std::uint32_t seed : {0u, 5u}) {
            const BaseVolume v = sample(name, seed);
            for (int axis : {0, 1}) {
                EXPECT_LT(periodicityError(v, axis), 1.75) << name << ", seed " << seed << ", axis " << axis;
            }
        }
    }
}

// The check above finds a seam: two samples side by side do not fit.
TEST(MakeSample, PeriodicityFindsTwoSamplesSideBySide) {
    for (const std::string name : {"marble", "jade", "skin", "coral", "ice"}) {
        const Vec3i size{48, 48, 16};
        BaseVolume v = sample(name, 0, size);
        const double without = periodicityError(v, 0);
        const BaseVolume other = sample(name, 5, size);
        for (std::size_t i = 0; i < v.voxelCount(); ++i) {
            if (int(i % std::size_t(v.size.x)) >= v.size.x / 2) {
                v.extinction[i] = other.extinction[i];
                v.albedo[i] = other.albedo[i];
                if (!v.surface.empty()) {
                    v.surface[i] = other.surface[i];
                }
            }
        }
        EXPECT_GT(periodicityError(v, 0), 1.3 * without) << name;
    }
}

TEST(MakeSample, SeedChangesEverySample) {
    for (const std::string name : {"jade", "skin", "coral", "ice"}) {
        EXPECT_NE(sample(name, 1, {16, 16, 8}).contentHash(), sample(name, 2, {16, 16, 8}).contentHash()) << name;
    }
}

// A sphere's nearest copy, across the sides of the tile too: the coral's distance is that to its holes.
TEST(MakeSample, CoralHasHolesInside) {
    const VolumeStatistics s = statisticsOf(sample("coral"));
    ASSERT_TRUE(s.surface);
    EXPECT_GT(s.surface->overhangShare, 0.3) << "holes below the surface";
    EXPECT_GT(s.filledShare, 0.6);
    EXPECT_LT(s.thicknessMm, 0.95 * sample("coral").extentMm().z);
}

TEST(MakeSample, SkinIsLayered) {
    const BaseVolume v = sample("skin");
    const Material fat = PropertyTable::builtIn().find("tissue/Fat");
    const std::size_t bottom = v.index(5, 7, v.size.z - 1);
    EXPECT_NEAR(v.extinction[bottom].x, fat.extinction().x, 1e-5);
    EXPECT_NEAR(v.extinction[bottom].z, fat.extinction().z, 1e-5);
    // More is absorbed in the epidermis' layer, on average, than in the dermis below it.
    const auto absorbed = [&](double from, double to) {
        double sum = 0;
        std::size_t count = 0;
        const std::vector<float> depths = surfaceDepths(v);
        for (int z = 0; z < v.size.z; ++z) {
            for (int y = 0; y < v.size.y; ++y) {
                for (int x = 0; x < v.size.x; ++x) {
                    const double depth = (z + 0.5) * v.voxelMm.z -
                                         double(depths[std::size_t(x) + std::size_t(v.size.x) * std::size_t(y)]);
                    if (depth > from && depth < to) {
                        const std::size_t i = v.index(x, y, z);
                        sum += double(v.extinction[i].x * (1 - v.albedo[i].x));
                        ++count;
                    }
                }
            }
        }
        return sum / double(count);
    };
    EXPECT_GT(absorbed(0, 0.06), 3 * absorbed(0.6, 1.0));
}

TEST(MakeSample, WaxHasTheSymmetryOfTheSquare) {
    const BaseVolume v = sample("wax");
    const int n = v.size.x;
    ASSERT_EQ(n, v.size.y);
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const std::size_t i = v.index(x, y, z);
                for (std::size_t j : {v.index(n - 1 - x, y, z), v.index(x, n - 1 - y, z), v.index(y, x, z)}) {
                    ASSERT_NEAR(v.extinction[i].x, v.extinction[j].x, 1e-5f);
                    ASSERT_NEAR(v.surface[i], v.surface[j], 1e-5f);
                }
            }
        }
    }
}

TEST(MakeSample, WaxHasReliefAndVoidsAboveIt) {
    const BaseVolume v = sample("wax");
    EXPECT_TRUE(v.hasRelief());
    std::size_t voids = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const bool outside = v.surface[i] > float(v.voxelMm.x);
        ASSERT_EQ(v.extinction[i].x, outside ? 0.0f : 2.0f) << "material wherever the surface may cut a voxel";
        voids += v.extinction[i].x == 0;
    }
    EXPECT_GT(voids, 0u);
    for (int y = 0; y < v.size.y; ++y) { // the bottom is filled
        ASSERT_EQ(v.extinction[v.index(3, y, v.size.z - 1)].x, 2.0f);
    }
}

TEST(MakeSample, UniformFollowsItsOptions) {
    SampleOptions options;
    options.size = {2, 3, 4};
    options.voxelMm = 0.5;
    options.extinction = {1, 2, 3};
    options.albedo = {0.5f, 0.75f, 1};
    options.g = 0.5f;
    const BaseVolume v = makeSample("uniform", options);
    EXPECT_EQ(v.voxelMm, Vec3d(0.5));
    EXPECT_TRUE(v.laterallyUniform());
    EXPECT_EQ(v.extinction[23], options.extinction);
    EXPECT_EQ(v.albedo[0], options.albedo);
    EXPECT_EQ(v.g[7], 0.5f);
    EXPECT_NEAR(v.coreSigmaA.x, 0.5, 1e-6);
    EXPECT_NEAR(v.coreSigmaSPrime.y, 0.75, 1e-6);
    options.g = 0;
    EXPECT_TRUE(makeSample("uniform", options).g.empty());
}

} // namespace
