// SPDX-License-Identifier: Apache-2.0
#include "stfLib/reference/reference_medium.h"

#include <gtest/gtest.h>

namespace stf {
namespace {

// A plane that leans: the distance is linear, so that interpolation is exact between the middles of voxels.
BaseVolume leaning() {
    BaseVolume v;
    v.size = {4, 4, 8};
    v.voxelMm = {0.5, 0.5, 0.25};
    v.extinction.assign(v.voxelCount(), Rgb(0.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.5f));
    v.ior.assign(v.voxelCount(), 1.0f);
    v.surface.assign(v.voxelCount(), 0);
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < v.size.y; ++y) {
            for (int x = 0; x < v.size.x; ++x) {
                const std::size_t i = v.index(x, y, z);
                v.surface[i] = float(0.75 - (z + 0.5) * 0.25 + 0.2 * (y == 1 ? 0.5 : 0.0));
                if (v.surface[i] < 0) {
                    v.extinction[i] = Rgb(2, 3, 1);
                    v.ior[i] = 1.3f;
                }
            }
        }
    }
    return v;
}

TEST(ReferenceMedium, ReliefIsLinearBetweenVoxels) {
    const ReferenceMedium m(std::make_shared<const BaseVolume>(leaning()));
    EXPECT_TRUE(m.hasRelief());
    EXPECT_NEAR(m.distance({0.3f, 1.5f, 0.6f}), 0.15f, 1e-6f);
    EXPECT_NEAR(m.distance({0.3f, 0.75f, 0.6f}), 0.25f, 1e-6f) << "row of voxels with a ridge";
    EXPECT_NEAR(m.distance({0.3f, 0.5f, 0.6f}), 0.2f, 1e-6f) << "half way to it";
    EXPECT_NEAR(m.distance({2.3f, -1.25f, 0.6f}), m.distance({0.3f, 0.75f, 0.6f}), 1e-6f) << "periodic";
    const Vec3f slope = m.gradient({0.3f, 0.5f, 0.6f});
    EXPECT_NEAR(slope.y, 0.2f, 1e-3f);
    EXPECT_NEAR(slope.z, -1, 1e-3f);
    EXPECT_FALSE(m.inside({0.3f, 1.5f, 0.74f}));
    EXPECT_TRUE(m.inside({0.3f, 1.5f, 0.76f}));
}

TEST(ReferenceMedium, KnowsTheMaterial) {
    const ReferenceMedium m(std::make_shared<const BaseVolume>(leaning()));
    EXPECT_TRUE(m.refracts());
    EXPECT_FLOAT_EQ(m.majorant(), 3);
    EXPECT_FLOAT_EQ(m.iorBelow({0.3f, 1.5f, 0.1f}), 1.3f);
    const std::size_t empty = m.voxelAt({0.3f, 0.75f, 0.8f});
    EXPECT_EQ(m.extinction(empty), Rgb(2, 3, 1)) << "cut by the surface, left empty: what lies next to it";
    EXPECT_TRUE(m.aboveLastLayer(1.7f));
    EXPECT_FALSE(m.aboveLastLayer(1.8f));
}

} // namespace
} // namespace stf
