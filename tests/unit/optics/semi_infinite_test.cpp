// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/semi_infinite.h"

#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/h_function.h"
#include "stfLib/optics/materials_json.h"
#include "stfLib/optics/property_table.h"

#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace stf;

namespace {

// Per flux entered, by adding and doubling with 256 angles: another method.
TEST(SemiInfinite, AgreesWithAddingDoubling) {
    const struct {
        double albedo, at13, at15;
    } rows[] = {{0.3, 0.029871, 0.021406},  {0.5, 0.063486, 0.046089},  {0.8, 0.181324, 0.137478},
                {0.9, 0.290729, 0.229082},  {0.95, 0.407815, 0.334498}, {0.99, 0.656564, 0.585397},
                {0.999, 0.871583, 0.834853}};
    for (const auto& row : rows) {
        EXPECT_NEAR(semiInfiniteReflectance(1 - row.albedo, 1.3), row.at13, 2e-6) << row.albedo;
        EXPECT_NEAR(semiInfiniteReflectance(1 - row.albedo, 1.5), row.at15, 2e-6) << row.albedo;
    }
}

TEST(SemiInfinite, Limits) {
    for (double ior : {0.8, 1.0, 1.3, 2.5}) {
        EXPECT_EQ(semiInfiniteReflectance(1, ior), 0);
        EXPECT_EQ(semiInfiniteReflectance(0, ior), 1);
        // Little absorption loses little, whatever the interface holds back.
        EXPECT_NEAR(semiInfiniteReflectance(1e-12, ior), 1, 3e-5) << ior;
    }
    EXPECT_NEAR(semiInfiniteReflectance(0.1, 1), HFunction(0.1).reflectance(1), 1e-12);
    EXPECT_NEAR(semiInfiniteReflectance(0.1, 1 + 1e-7), HFunction(0.1).reflectance(1), 1e-5) << "continuous at n = 1";
}

// The published column has two digits and is the dipole's, which itself is off by a few hundredths.
TEST(SemiInfinite, PublishedReflectance) {
    const nlohmann::json data = nlohmann::json::parse(builtInMaterialsJson())["jensen2001"];
    for (const auto& [name, values] : data.items()) {
        const Vec3d r = diffuseReflectance(PropertyTable::builtIn().find("jensen2001/" + name));
        for (int c = 0; c < 3; ++c) {
            const double published = values["diffuse_reflectance_table"][std::size_t(c)].get<double>();
            EXPECT_NEAR(r[c], published, 0.02) << name << ", channel " << c;
        }
    }
}

TEST(SemiInfinite, Lengths) {
    Material m;
    m.sigmaA = {0.1, 0, 0.2};
    m.sigmaS = {10, 10, 0};
    m.g = 0.5;
    EXPECT_NEAR(meanFreePathMm(m).x, 1 / 5.1, 1e-14);
    EXPECT_NEAR(diffusionLengthMm(m).x, 1 / std::sqrt(3 * 0.1 * 5.1), 1e-14);
    EXPECT_TRUE(std::isinf(diffusionLengthMm(m).y));
    EXPECT_EQ(diffuseReflectance(m).y, 1);
    EXPECT_EQ(diffuseReflectance(m).z, 0);
    EXPECT_NEAR(diffuseReflectance(m).x, semiInfiniteReflectance(0.1 / 5.1, 1), 1e-12);
    EXPECT_TRUE(std::isinf(meanFreePathMm(Material()).x));
    EXPECT_EQ(diffuseReflectance(Material()), Vec3d(0.0));
}

} // namespace
