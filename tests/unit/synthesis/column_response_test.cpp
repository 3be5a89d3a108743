// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/column_response.h"

#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

TEST(ColumnResponse, OfALayerWithoutAbsorptionIsSdOverOnePlusSd) {
    for (double sd : {1e-6, 0.1, 1.0, 30.0}) {
        EXPECT_NEAR(layerReflectance(0, sd, 1, 0), sd / (1 + sd), 1e-7);
    }
}

TEST(ColumnResponse, OfAThickLayerForgetsItsBackground) {
    // Kubelka & Munk: K / S = (1 - R)^2 / (2 R).
    for (double r : {0.1, 0.5, 0.9}) {
        const double k = (1 - r) * (1 - r) / (2 * r);
        EXPECT_NEAR(layerReflectance(k, 1, 200, 0.3), r, 1e-6);
    }
}

TEST(ColumnResponse, TwoLayersAreOneOfBothDepths) {
    const double k = 0.3, s = 1.1;
    const double together = layerReflectance(k, s, 1.7, 0.2);
    EXPECT_NEAR(layerReflectance(k, s, 0.9, layerReflectance(k, s, 0.8, 0.2)), together, 1e-12);
    EXPECT_NEAR(layerReflectance(0.3, 0, 2, 0.5), 0.5 * std::exp(-1.2), 1e-12);
}

TEST(ColumnResponse, SeesDarkColumnsAndSkipsWhatIsOutsideTheSurface) {
    BaseVolume v = waves(16);
    std::vector<Rgb> r = columnResponse(v);
    for (std::size_t i = 0; i < r.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (v.albedo[i].x > v.albedo[j].x + 1e-4f) {
                EXPECT_GT(r[i].x, r[j].x);
            }
        }
    }
    // Black material that lies outside: the top layer no longer counts.
    v.surface.assign(v.voxelCount(), -1.0f);
    const float before = columnResponse(v)[5].x;
    v.surface[5] = 0.3f;
    v.albedo[5] = Rgb(0.0f);
    EXPECT_NEAR(columnResponse(v)[5].x, before, 0.1f);
}
