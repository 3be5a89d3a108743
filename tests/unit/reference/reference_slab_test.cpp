// SPDX-License-Identifier: Apache-2.0
// The path traced reference on flat slabs against adding-doubling and closed forms.
#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/semi_infinite.h"
#include "stfLib/reference/reference_integrator.h"
#include "tests/unit/render/slab_fixture.h"
#include "tests/unit/support/files.h"

namespace stf::test {
namespace {

Slab traced(int samples) {
    Slab slab;
    slab.reference = &ReferenceIntegrator::maker;
    slab.settings.integrator = "reference";
    slab.settings.samples = samples;
    slab.layersPerMm = 2;
    return slab;
}

// What a slab over black reflects: light that comes out of its bottom is lost, which a slab whose bottom refracts would
// reflect. So where the index is not 1 slabs are thick; `depth` is then enough of the tau in the table.
struct SlabCase {
    double tau, albedo, g, n;
    int samples;
    double depth;
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
    slab.tau = p.depth;
    slab.extinction = p.depth / 2; // 2 mm deep: so far from the quad's rim that nothing gets there
    const double normal = (*found)["normal"]["R_total"].get<double>() - (*found)["normal"]["R_specular"].get<double>();
    const double peak = std::abs(p.g) > 0.8 ? 0.4 : 0; // of the phase function, which the quadrature has to see
    if (p.n == 1 || p.g < 0.8) {                       // else the noise of so narrow a light is too large
        EXPECT_TRUE(slab.reflectance(peak).near(normal, 0.002)) << "parallel light";
    }
    slab.lit = Slab::Lit::Dome;
    // Forward scattering brings it out at grazing angles: two panels of the quadrature.
    EXPECT_TRUE(slab.reflectance(p.g > 0.8 ? 1.0 : 0.0).near((*found)["diffuse"]["R_total"], 1e-3)) << "diffuse light";
}

std::string caseName(const testing::TestParamInfo<SlabCase>& i) {
    const auto number = [](double v) { return std::to_string(int(std::lround(std::abs(v) * 100))); };
    return "tau" + number(i.param.tau) + "albedo" + number(i.param.albedo) + (i.param.g < 0 ? "back" : "g") +
           number(i.param.g) + "n" + number(i.param.n);
}
INSTANTIATE_TEST_SUITE_P(Cases, ReferenceSlab,
                         testing::Values(SlabCase{1, 0.5, 0.9, 1, 4096, 1}, SlabCase{2, 0.9, -0.9, 1, 256, 2},
                                         SlabCase{5, 0.99, 0.5, 1, 128, 5}, SlabCase{16, 0.999999, 0, 1, 256, 16},
                                         SlabCase{100, 0.9, 0.9, 1.33, 1024, 30}, SlabCase{400, 0.9, 0, 1.5, 256, 12}),
                         caseName);

// Shell over core: the walk in the core is the medium that the dipole of the STF stands for.
TEST(ReferenceCore, ReflectsAsLayers) {
    const nlohmann::json slabs = reference("slab_cases.json");
    const auto& layered = slabs["layered"][0];
    ASSERT_EQ(layered["layers"][1]["albedo"], 0.99);
    Slab slab = traced(256);
    slab.albedo = 0.9;
    slab.tau = 2;
    slab.coreAlbedo = 0.99;
    EXPECT_TRUE(slab.reflectance().near(layered["R_total_normal"], 0.002));
    slab.lit = Slab::Lit::Dome;
    EXPECT_TRUE(slab.reflectance().near(layered["R_total_diffuse"], 0.002));
}

// A core that is the shell's own medium under a refracting top: half a space of it.
TEST(ReferenceCore, IsOneWithItsShell) {
    const nlohmann::json slabs = reference("slab_cases.json");
    for (const auto& c : slabs["cases"]) {
        if (c["tau"] == 400 && c["n"] == 1.5) {
            Slab slab = traced(512);
            slab.albedo = 0.9;
            slab.ior = 1.5;
            slab.coreAlbedo = 0.9;
            const double specular = c["normal"]["R_specular"];
            EXPECT_TRUE(slab.reflectance().near(c["normal"]["R_total"].get<double>() - specular, 0.003));
            slab.lit = Slab::Lit::Dome;
            EXPECT_TRUE(slab.reflectance().near(c["diffuse"]["R_total"], 0.002));
        }
    }
}

// A shell of nothing shows the core behind it as it is.
TEST(ReferenceCore, IsSeenThroughNothing) {
    for (const double extinction : {1e-6, 0.0}) {
        Slab slab = traced(512);
        slab.shape = [=](BaseVolume& v) { v.extinction.assign(v.voxelCount(), Rgb(float(extinction))); };
        slab.coreAlbedo = 0.9;
        EXPECT_TRUE(slab.reflectance().near(semiInfiniteReflectance(0.1, 1), 0.003)) << extinction;
    }
}

// Emission alone: (1 - exp(-tau / mu)) e / kappa, over n^2 and less by Fresnel where the top refracts.
TEST(ReferenceSlab, Emission) {
    for (const double view : {1.0, 0.5}) {
        Slab slab = traced(1024);
        slab.albedo = 0;
        slab.emission = 0.7;
        slab.lit = Slab::Lit::Dark;
        slab.viewCosine = view;
        EXPECT_TRUE(slab.radiance().near(0.7 * (1 - std::exp(-2 / view)), 1e-3));
        slab.ior = 1.4;
        const auto in = fresnelSplit<double>(view, 1.4);
        EXPECT_TRUE(slab.radiance().near((1 - in.reflectance) / 1.96 * 0.7 * (1 - std::exp(-2 / in.cosT)), 1e-3));
    }
}

// The same picture whatever the number of threads.
TEST(ReferenceSlab, ThreadsDoNotMatter) {
    Slab slab = traced(8);
    slab.ior = 1.3;
    slab.coreAlbedo = 0.9;
    slab.settings.threads = 1;
    const std::vector<float> one = slab.render();
    slab.settings.threads = 2;
    EXPECT_EQ(slab.render(), one);
    EXPECT_GT(one[0], 0);
}

} // namespace
} // namespace stf::test
