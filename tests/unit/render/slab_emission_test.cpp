// SPDX-License-Identifier: Apache-2.0
// Flat shells that shine themselves, without any light, against closed forms.
#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/h_function.h"
#include "tests/unit/render/slab_fixture.h"

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

Slab shining(double tau, double extinction, double emission) {
    Slab slab;
    slab.lit = Slab::Lit::Dark;
    slab.tau = tau;
    slab.extinction = extinction;
    slab.emission = emission;
    return slab;
}

// L = e h / mu; refracted: (1 - F) / n^2 e h / mu_t. What the thin layer absorbs and scatters is below 0.1 %.
TEST(SlabEmission, OpticallyThin) {
    for (const double ior : {1.0, 1.5}) {
        for (const double mu : {1.0, 0.5}) {
            Slab slab = shining(1e-4, 1e-4, 0.3);
            slab.quality = 0.1f;
            slab.ior = ior;
            slab.viewCosine = mu;
            const auto s = fresnelSplit<double>(mu, ior);
            Slab::Measured r = slab.radiance();
            r.table = 0;
            EXPECT_TRUE(r.near(0.3 / s.cosT * (1 - s.reflectance) / (ior * ior), 2e-3))
                << "index " << ior << ", mu " << mu;
            EXPECT_TRUE(slab.messages.empty()) << slab.messages.front();
        }
    }
}

// An isothermal half space, emission kappa (1 - a): by reciprocity it shines with 1 - R(mu) = sqrt(1 - a) H(mu)
// (Chandrasekhar 1960, chapter V).
TEST(SlabEmission, IsothermalHalfSpace) {
    for (const double mu : {1.0, 0.4}) {
        Slab slab = shining(16, 1, 0.1);
        slab.albedo = 0.9;
        slab.viewCosine = mu;
        const HFunction h(0.1);
        EXPECT_TRUE(slab.radiance().near(std::sqrt(0.1) * h(mu), 0.01)) << "mu " << mu;
    }
}

// An absorbing layer that shines onto a core: the core sends back R_cd of 2 pi INT (e / kappa) (1 - exp(-tau / mu)) mu
// dmu, and is seen through the layer.
TEST(SlabEmission, LightsTheCore) {
    Slab slab = shining(1, 1, 0.5);
    slab.albedo = 0;
    slab.coreAlbedo = 0.9;
    double down = 0;
    constexpr int kSteps = 10000;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        down += 2 * kPi * 0.5 * (1 - std::exp(-1 / mu)) * mu / kSteps;
    }
    const double exitance = HFunction(0.1).diffuseReflectance() * down;
    EXPECT_TRUE(slab.radiance().near(0.5 * (1 - std::exp(-1.0)) + exitance / kPi * std::exp(-1.0), 0.01));
}

} // namespace
} // namespace stf::test
