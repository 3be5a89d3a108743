// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/material_blend.h"

#include <gtest/gtest.h>

using namespace stf;

namespace {

// Half a voxel of air is a cut where the surface passes, and pores where it does not.
TEST(MaterialBlend, PoresAreNoCut) {
    BaseVolume v;
    v.size = {3, 1, 1};
    v.surface = {-0.2f, -0.9f, -2.0f};
    v.voxelMm = {1, 1, 1};
    Material wax;
    wax.name = "wax";
    wax.sigmaS = Vec3d(4.0);
    blendMaterials(v, {wax}, {0.5f, 0.5f, 0.25f});
    EXPECT_EQ(v.extinction[0], Rgb(4.0f));
    EXPECT_EQ(v.extinction[1], Rgb(2.0f));
    EXPECT_EQ(v.extinction[2], Rgb(1.0f));
}

} // namespace
