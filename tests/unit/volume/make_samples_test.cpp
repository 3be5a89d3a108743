// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/make_samples.h"

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

// Mean squared difference of neighbours across x (axis 0) or y (axis 1), between columns i and i + 1 (wrapped).
template<class Value>
double step(const BaseVolume& v, int axis, int i, Value value) {
    double sum = 0;
    const int n = axis == 0 ? v.size.y : v.size.x, next = (i + 1) % v.size[axis];
    for (int z = 0; z < v.size.z; ++z) {
        for (int k = 0; k < n; ++k) {
            const std::size_t a = axis == 0 ? v.index(i, k, z) : v.index(k, i, z);
            const std::size_t b = axis == 0 ? v.index(next, k, z) : v.index(k, next, z);
            sum += std::pow(value(a) - value(b), 2);
        }
    }
    return sum;
}

template<class Value>
void expectPeriodic(const BaseVolume& v, Value value) {
    for (int axis : {0, 1}) {
        double largest = 0, mean = 0;
        const int n = v.size[axis];
        for (int i = 0; i + 1 < n; ++i) {
            const double s = step(v, axis, i, value);
            largest = std::max(largest, s);
            mean += s / (n - 1);
        }
        const double seam = step(v, axis, n - 1, value);
        EXPECT_LE(seam, largest) << v.name << " has a seam along axis " << axis;
        EXPECT_LE(seam, 3 * mean) << v.name << " has a seam along axis " << axis;
        EXPECT_GT(mean, 0);
    }
}

TEST(MakeSample, Periodic) {
    for (std::uint32_t seed : {0, 5}) {
        const BaseVolume marble = sample("marble", seed);
        expectPeriodic(marble, [&](std::size_t i) { return double(marble.albedo[i].z); });
    }
    const BaseVolume wax = sample("wax");
    expectPeriodic(wax, [&](std::size_t i) { return double(wax.extinction[i].x); });
    expectPeriodic(wax, [&](std::size_t i) { return double(wax.surface[i]); });
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
