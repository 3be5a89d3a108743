// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/volume_statistics.h"

#include "tests/unit/volume/volumes.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

TEST(VolumeStatistics, OfAHomogeneousSlab) {
    BaseVolume v = homogeneous({8, 6, 10}, {0.5, 0.5, 0.25}, Rgb(4, 2, 1), Rgb(0.5f, 0.75f, 1.0f), 0.5f);
    v.ior.assign(v.voxelCount(), 1.5f);
    const VolumeStatistics s = statisticsOf(v);
    EXPECT_EQ(s.opticalDepthMean, Vec3d(10, 5, 2.5));
    EXPECT_EQ(s.opticalDepthMin, s.opticalDepthMax);
    EXPECT_EQ(s.extinctionMin, Vec3d(4, 2, 1));
    EXPECT_NEAR(s.mean.sigmaA.y, 0.5, 1e-12);
    EXPECT_NEAR(s.mean.sigmaSPrime.y, 0.75, 1e-12);
    EXPECT_NEAR(s.diffusionLengthMm.y, 1 / std::sqrt(3 * 0.5 * 1.25), 1e-12);
    EXPECT_TRUE(std::isinf(s.diffusionLengthMm.z));
    EXPECT_EQ(s.thicknessMm, 2.5);
    EXPECT_EQ(s.filledShare, 1);
    EXPECT_EQ(s.periodicity[0], 1);
    EXPECT_EQ(s.periodicity[1], 1);
    EXPECT_EQ(s.iorMax, 1.5);
    EXPECT_EQ(s.bytes, v.voxelCount() * (12 + 12 + 4 + 4));
    EXPECT_FALSE(s.surface);
}

// Diffuse light, isotropic scattering, n = 1.3, by adding and doubling: what the slab over a black core lacks.
TEST(VolumeStatistics, ShareFromBelowAgainstExactSlabs) {
    const struct {
        double albedo, lengths, share;
    } rows[] = {{0.95, 0.39, 0.49},  {0.95, 0.77, 0.23},  {0.95, 1.55, 0.048},  {0.95, 3.10, 0.0023},
                {0.99, 0.35, 0.40},  {0.99, 0.69, 0.17},  {0.99, 1.39, 0.040},  {0.99, 2.77, 0.0024},
                {0.999, 0.22, 0.31}, {0.999, 0.44, 0.15}, {0.999, 0.88, 0.048}, {0.999, 1.75, 0.0073}};
    for (const auto& row : rows) {
        const double absorption = 1 - row.albedo, length = 1 / std::sqrt(3 * absorption);
        const double share = shareFromBelow(absorption, row.albedo, 1.3, row.lengths * length);
        EXPECT_NEAR(share / row.share, 1, 0.33) << row.albedo << ", " << row.lengths;
        EXPECT_NEAR(thicknessForShare(absorption, row.albedo, 1.3, share) / (row.lengths * length), 1, 1e-9);
    }
    EXPECT_EQ(shareFromBelow(1, 0, 1.3, 1), 0) << "a black medium lacks nothing";
    EXPECT_NEAR(shareFromBelow(1e-13, 2, 1, 3) / shareFromBelow(0, 2, 1, 3), 1, 0.5) << "little absorption, and none";
    EXPECT_TRUE(std::isinf(thicknessForShare(0, 1, 1, 0.05)));
}

TEST(VolumeStatistics, PeriodicityTellsASeam) {
    const int n = 32;
    BaseVolume v = homogeneous({n, n, 2}, Vec3d(1.0), Rgb(1.0f), Rgb(0.5f));
    const double kTwoPi = 6.283185307179586;
    const auto fill = [&](double turnsX, double turnsY) {
        for (std::size_t i = 0; i < v.voxelCount(); ++i) {
            const double x = double(i % n) / n, y = double(i / n % n) / n;
            v.extinction[i] = Rgb(float(2 + std::cos(kTwoPi * turnsX * x) + 0.5 * std::sin(kTwoPi * turnsY * y)));
        }
    };
    fill(2, 3);
    EXPECT_NEAR(periodicityError(v, 0), 1, 1) << "no seam";
    EXPECT_LT(periodicityError(v, 0), 1.2);
    EXPECT_LT(periodicityError(v, 1), 1.6);
    fill(2.5, 3);
    EXPECT_GT(periodicityError(v, 0), 4) << "half a turn is missing";
    EXPECT_LT(periodicityError(v, 1), 1.6);
    // Only the surface has a seam.
    fill(0, 0);
    v.surface.resize(v.voxelCount());
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.surface[i] = float(double(i / n % n) / n * 2 - 1);
    }
    EXPECT_EQ(periodicityError(v, 0), 1);
    EXPECT_GT(periodicityError(v, 1), 20);
}

// A slope of 45 degrees up and down again along x, cut into a medium; a column of nothing.
TEST(VolumeStatistics, SurfaceOfARoof) {
    const int n = 16;
    BaseVolume v = homogeneous({n, 4, 12}, Vec3d(0.5), Rgb(1.0f), Rgb(0.5f));
    v.surface.resize(v.voxelCount());
    const auto depthAt = [&](int x) { return 0.25 + 0.5 * std::min(x, n - 1 - x); };
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < v.size.y; ++y) {
            for (int x = 0; x < n; ++x) {
                const double outside = (depthAt(x) - (z + 0.5) * 0.5) / std::sqrt(2.0);
                v.surface[v.index(x, y, z)] = float(x == 3 && y == 0 ? 1.0 : outside);
            }
        }
    }
    const std::vector<float> depths = surfaceDepths(v);
    for (int x = 1; x < n - 1; ++x) {
        EXPECT_NEAR(depths[std::size_t(x + n)], depthAt(x), 1e-6);
    }
    EXPECT_LT(depths[3], 0);
    const VolumeStatistics s = statisticsOf(v);
    ASSERT_TRUE(s.surface);
    EXPECT_NEAR(s.surface->steepest, 45, 1e-3);
    EXPECT_NEAR(s.surface->emptyShare, 1.0 / (4 * n), 1e-12);
    EXPECT_EQ(s.surface->overhangShare, 0);
    EXPECT_NEAR(s.surface->lowestMm, 3.75, 1e-6);
    v.surface[v.index(8, 2, 11)] = 1; // a void under the roof
    EXPECT_NEAR(statisticsOf(v).surface->overhangShare, 1.0 / (4 * n), 1e-12);
}

} // namespace
