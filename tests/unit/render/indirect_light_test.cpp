// SPDX-License-Identifier: Apache-2.0
// Light that shells get from other surfaces, shells among them, and how it is kept.
#include "stfLib/render/indirect_light.h"

#include "stfLib/base/hemisphere.h"
#include "stfLib/reference/reference_integrator.h"
#include "tests/unit/render/slab_fixture.h"

namespace stf::test {
namespace {

constexpr float kPi = 3.14159265358979f;

// Of rays that were drawn by the cosine, directions that stand for the radiance they bring: all of the irradiance
// comes, and from where the light is. Moments of a radiance that depends on direction, by the same rays.
TEST(IndirectLight, DirectionsBringTheIrradianceFromWhereItComes) {
    const Vec3f normal(0, 0, 1);
    const auto radiance = [](const Vec3f& d, int which) {
        return which == 0 ? 1.0f : which == 1 ? 1 + 0.9f * d.x : d.z < 0.3f ? 5.0f : 0.2f; // even, tilted, a low ring
    };
    for (int which = 0; which < 3; ++which) {
        constexpr std::size_t kSamples = 64;
        constexpr int kRays = 128;
        IndirectLight light;
        light.mean = {Rgb(2.0f), Rgb(2.0f), Rgb(2.0f)};
        light.sample = {0, 0, 0};
        light.directions.resize(kSamples * IndirectLight::kDirections);
        Vec3d expected(0.0), found(0.0);
        double weights = 0;
        for (std::size_t i = 0; i < kSamples; ++i) {
            std::vector<IndirectRay> rays;
            for (int k = 0; k < kRays; ++k) {
                PixelSampler sampler(7, i, std::uint32_t(k));
                const Vec3f d = cosineHemisphere(sampler.next2d());
                const float r = radiance(d, which);
                rays.push_back({d, Rgb(r)});
                expected += Vec3d(d) * double(r);
                weights += double(r);
            }
            chooseDirections(rays, normal, float(i) / kSamples, &light.directions[i * IndirectLight::kDirections]);
        }
        constexpr int kPicks = 256;
        for (std::size_t i = 0; i < kSamples; ++i) {
            light.sample = {std::uint32_t(i), std::uint32_t(i), std::uint32_t(i)};
            for (int k = 0; k < kPicks; ++k) {
                PixelSampler sampler(3, i, std::uint32_t(k));
                const IndirectSample s = sampleIndirect(light, {0, 1, 2}, 0.2f, 0.3f, normal, sampler);
                double irradiance = 0;
                for (int d = 0; d < IndirectSample::kDirections; ++d) {
                    EXPECT_NEAR(length(s.towards[d]), 1, 1e-5);
                    const double share = double(s.irradiance[d].y) * double(s.towards[d].z);
                    irradiance += share;
                    found += Vec3d(s.towards[d]) * (share / (2 * double(kPi) * kSamples * kPicks));
                }
                ASSERT_NEAR(irradiance, 2 * double(kPi), 1e-4);
            }
        }
        // 2048 directions, whose azimuths are as good as random: .011 is their standard error.
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(found[c], expected[c] / weights, 0.025) << "radiance " << which << ", axis " << c;
        }
    }
}

Slab underCeiling(double albedo) {
    Slab slab;
    slab.lit = Slab::Lit::Dome;
    slab.albedo = slab.coreAlbedo = albedo;
    slab.tau = 4;
    slab.quality = 0.003f;
    slab.ceilingMm = 30;
    slab.viewCosine = 0.2; // from below the ceiling
    slab.settings.samples = 64;
    return slab;
}

// Two white plates that face each other under a dome of radiance 1 look as bright as the dome: most of what each gets
// comes from the other. Whichever way it is looked for.
TEST(ShellExchange, WhitePlatesThatFaceEachOtherAreAFurnace) {
    for (const bool kept : {true, false}) {
        Slab slab = underCeiling(1);
        slab.settings.irradianceCache = kept;
        slab.settings.samples = kept ? 64 : 512;
        EXPECT_TRUE(slab.radiance().near(1, 0.015)) << (kept ? "kept" : "traced");
        bool exchanged = false;
        for (const PlanEntry& e : slab.plan) {
            exchanged = exchanged || (e.stage == "indirect" && e.runs && e.why.find("rounds") != std::string::npos);
        }
        EXPECT_TRUE(exchanged);
    }
}

// Plates that absorb, against path tracing; without the ceiling's light they are far darker.
TEST(ShellExchange, AgreesWithPathTracing) {
    Slab slab = underCeiling(0.98);
    const Slab::Measured stf = slab.radiance();
    slab.reference = &ReferenceIntegrator::maker;
    slab.settings.integrator = "reference";
    slab.settings.samples = 1024;
    const Slab::Measured exact = slab.radiance();
    EXPECT_LT(exact.error, 0.015 * exact.mean);
    EXPECT_NEAR(stf.mean, exact.mean, 4 * std::hypot(stf.error, exact.error) + (stf.table + 0.02) * exact.mean);

    Slab dark = underCeiling(0.98);
    dark.settings.maxDepth = 0;
    EXPECT_LT(dark.radiance().mean, 0.7 * stf.mean);
}

TEST(ShellExchange, NothingToExchangeIsLeftOut) {
    Slab slab;
    slab.settings.samples = 1;
    slab.lit = Slab::Lit::Dome;
    slab.render();
    bool said = false;
    for (const PlanEntry& e : slab.plan) {
        said = said || (e.stage == "indirect" && e.why.find("rounds of light between shells: 0") != std::string::npos);
    }
    EXPECT_TRUE(said);
}

} // namespace
} // namespace stf::test
