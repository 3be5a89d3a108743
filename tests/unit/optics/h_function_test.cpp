// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/h_function.h"

#include "tests/unit/support/files.h"

#include <cmath>

using namespace stf;
using namespace stf::test;

namespace {

TEST(HFunction, AgreesWithTheReferenceTable) {
    const nlohmann::json data = reference("hfunc.json");
    ASSERT_FALSE(data["table"].empty());
    for (const auto& [albedo, row] : data["table"].items()) {
        const HFunction h(1 - std::stod(albedo));
        for (std::size_t i = 0; i < data["mu"].size(); ++i) {
            const double mu = std::stod(data["mu"][i].get<std::string>());
            EXPECT_NEAR(h(mu) / row["H"][i].get<double>(), 1, 1e-6) << albedo << ", " << mu;
            EXPECT_NEAR(h.reflectance(mu), row["R_plane"][i].get<double>(), 1e-6) << albedo << ", " << mu;
        }
        EXPECT_NEAR(h.diffuseReflectance(), row["R_sph"].get<double>(), 1e-6) << albedo;
    }
}

TEST(HFunction, BlackMedium) {
    const HFunction h(1.0);
    for (double mu : {0.0, 0.3, 1.0}) {
        EXPECT_NEAR(h(mu), 1, 1e-12);
        EXPECT_NEAR(h.reflectance(mu), 0, 1e-12);
    }
    EXPECT_NEAR(h.diffuseReflectance(), 0, 1e-12);
}

TEST(HFunction, ConservativeMediumReturnsEverything) {
    const HFunction h(0.0);
    for (double mu : {0.0, 0.1, 1.0}) {
        EXPECT_EQ(h.reflectance(mu), 1);
    }
    EXPECT_EQ(h.diffuseReflectance(), 1);
    EXPECT_NEAR(h(1.0) / 2.9078105, 1, 1e-6); // Chandrasekhar 1960, table XI
}

TEST(HFunction, IsOneAtGrazing) {
    // H(0) = 1 for every albedo, which is the zeroth moment in disguise: INT H = 2 (1 - sqrt(1 - a)) / a.
    for (double absorption : {0.9, 0.5, 0.1, 1e-3, 1e-6, 0.0}) {
        EXPECT_NEAR(HFunction(absorption)(0.0), 1, 1e-6) << absorption;
    }
}

TEST(HFunction, SmallAbsorption) {
    // R_spherical = 1 - 4 sqrt((1 - a) / 3) + O(1 - a) (van de Hulst 1980, on the similarity of semi-infinite media).
    for (double absorption : {1e-6, 1e-8, 1e-10, 1e-14}) {
        const double loss = 1 - HFunction(absorption).diffuseReflectance();
        EXPECT_NEAR(loss / (4 * std::sqrt(absorption / 3)), 1, 3 * std::sqrt(absorption) + 1e-6) << absorption;
    }
}

TEST(HFunction, ReflectanceFallsWithAbsorption) {
    double last = 2;
    for (double absorption : {0.0, 1e-9, 1e-5, 1e-3, 0.01, 0.1, 0.3, 0.7, 1.0}) {
        const double r = HFunction(absorption).diffuseReflectance();
        EXPECT_LT(r, last);
        EXPECT_GE(r, -1e-12);
        last = r;
    }
}

TEST(HFunction, BeyondTheRangeIsTheEnd) {
    EXPECT_EQ(HFunction(-1e-9).diffuseReflectance(), 1);
    EXPECT_NEAR(HFunction(1.5).diffuseReflectance(), 0, 1e-12);
}

} // namespace
