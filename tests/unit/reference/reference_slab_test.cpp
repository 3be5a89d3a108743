// SPDX-License-Identifier: Apache-2.0
// The path traced reference on flat slabs against adding-doubling and closed forms.
#include "stfLib/reference/reference_integrator.h"
#include "tests/unit/render/slab_fixture.h"
#include "tests/unit/support/files.h"

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

Slab traced(int samples) {
    Slab slab;
    slab.reference = &ReferenceIntegrator::maker;
    slab.settings.integrator = "reference";
    slab.settings.samples = samples;
    slab.layersPerMm = 2;
    return slab;
}

// Over black, each order of scattering and all: L = a / (4 pi (mu + mu0)) ... is not closed beyond the first, so whole
// slabs are held against tables of adding-doubling.
struct SlabCase {
    double tau, albedo, g, n;
    int samples;
};

class ReferenceSlab : public testing::TestWithParam<SlabCase> {};

TEST_P(ReferenceSlab, ReflectsAsAddingDoubling) {
    const SlabCase& p = GetParam();
    const nlohmann::json slabs = reference("slab_cases.json");
    const nlohmann::json* found = nullptr;
    for (const auto& c : slabs["cases"]) {
        if (!c.contains("layers") && c["tau"] == p.tau && c["albedo"] == p.albedo && c["g"] == p.g && c["n"] == p.n) {
            found = &c;
        }
    }
    ASSERT_TRUE(found);
    Slab slab = traced(p.samples);
    slab.albedo = p.albedo;
    slab.g = p.g;
    slab.ior = p.n;
    slab.tau = p.tau;
    const double normal = (*found)["normal"]["R_total"].get<double>() - (*found)["normal"]["R_specular"].get<double>();
    EXPECT_TRUE(slab.reflectance().near(normal, 0.002)) << "parallel light";
    slab.lit = Slab::Lit::Dome;
    EXPECT_TRUE(slab.reflectance().near((*found)["diffuse"]["R_total"], 1e-3)) << "diffuse light";
}

std::string caseName(const testing::TestParamInfo<SlabCase>& i) {
    const auto number = [](double v) { return std::to_string(int(std::lround(std::abs(v) * 100))); };
    return "tau" + number(i.param.tau) + "albedo" + number(i.param.albedo) + (i.param.g < 0 ? "back" : "g") +
           number(i.param.g) + "n" + number(i.param.n);
}
INSTANTIATE_TEST_SUITE_P(Cases, ReferenceSlab,
                         testing::Values(SlabCase{1, 0.5, 0.9, 1, 1024}, SlabCase{2, 0.9, -0.9, 1, 64},
                                         SlabCase{5, 0.99, 0.5, 1, 64}, SlabCase{16, 0.999999, 0, 1, 16}),
                         caseName);

} // namespace
} // namespace stf::test
