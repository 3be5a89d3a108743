// SPDX-License-Identifier: Apache-2.0
// Shells as lights of plain surfaces, and what wide paths read of them.
#include "stfLib/render/shell_glow.h"

#include "stfLib/reference/reference_integrator.h"
#include "tests/unit/render/slab_fixture.h"

namespace stf::test {
namespace {

// A plain matte surface below a shell, under a dome of radiance 1.
Slab belowShell(double albedo, double ceilingMm) {
    Slab slab;
    slab.lit = Slab::Lit::Dome;
    slab.albedo = slab.coreAlbedo = slab.plainColor = albedo;
    slab.tau = 4;
    slab.quality = 0.003f;
    slab.ceilingMm = ceilingMm;
    slab.viewCosine = 0.2; // from below the ceiling
    slab.settings.samples = 256;
    slab.settings.maxDepth = 64;
    return slab;
}

// All white: as bright as the dome, near and far, whether the shell is found by samples of it, by rays, or both with
// their shares.
TEST(ShellGlow, WhiteSurfaceBelowAWhiteShellIsAFurnace) {
    for (const double ceilingMm : {6.0, 30.0}) {
        Slab slab = belowShell(1, ceilingMm);
        slab.viewCosine = ceilingMm < 10 ? 0.05 : 0.2;
        EXPECT_TRUE(slab.radiance().near(1, 0.015)) << ceilingMm;
    }
}

// Samples of shells change the noise, not the picture.
TEST(ShellGlow, AgreesWithPathTracing) {
    Slab slab = belowShell(0.9, 30);
    const Slab::Measured stf = slab.radiance();
    slab.settings.irradianceCache = false;
    slab.settings.samples = 1024;
    const Slab::Measured traced = slab.radiance();
    EXPECT_NEAR(stf.mean, traced.mean, 4 * std::hypot(stf.error, traced.error) + 0.015 * traced.mean);
    EXPECT_LT(stf.error * 16, traced.error * 32); // of one path
    slab.reference = &ReferenceIntegrator::maker;
    slab.settings.integrator = "reference";
    const Slab::Measured exact = slab.radiance();
    EXPECT_LT(exact.error, 0.015 * exact.mean);
    EXPECT_NEAR(stf.mean, exact.mean, 4 * std::hypot(stf.error, exact.error) + (stf.table + 0.02) * exact.mean);
}

// Light that refracts into the shell and what its surface mirrors together.
TEST(ShellGlow, MirrorsStayInTheFurnace) {
    Slab slab = belowShell(1, 30);
    slab.ior = 1.5;
    EXPECT_TRUE(slab.radiance().near(1, 0.02));
}

} // namespace
} // namespace stf::test
