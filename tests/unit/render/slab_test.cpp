// SPDX-License-Identifier: Apache-2.0
// The whole chain (tables, grid, march, core, film) on a flat homogeneous shell of index 1 and isotropic scattering
// against closed forms.
#include "stfLib/optics/h_function.h"
#include "tests/unit/render/slab_fixture.h"

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Radiance of a semi-infinite isotropic medium per unit perpendicular irradiance (Chandrasekhar 1960, chapter III):
// a mu0 H(mu) H(mu0) / (4 pi (mu + mu0)).
double semiInfinite(double albedo, double mu, double mu0) {
    const HFunction h(1 - albedo);
    return albedo * mu0 * h(mu) * h(mu0) / (4 * kPi * (mu + mu0));
}

// Single scattering of a layer over black: a mu0 / (4 pi (mu + mu0)) (1 - exp(-tau (1/mu + 1/mu0))).
double singleScattering(double albedo, double tau, double mu, double mu0) {
    return albedo * mu0 / (4 * kPi * (mu + mu0)) * (1 - std::exp(-tau * (1 / mu + 1 / mu0)));
}

std::shared_ptr<const StfTable> silencedTable(const std::shared_ptr<const BaseVolume>& volume,
                                              const TransportOptions& options, Progress& progress,
                                              const MessageSink& messages) {
    StfTable t = *Slab::sharedTables(volume, options, progress, messages);
    t.multiple = FactoredField();
    t.backlight = FactoredField();
    return std::make_shared<const StfTable>(std::move(t));
}

TEST(Slab, ThickShellIsSemiInfinite) {
    for (const double albedo : {0.5, 0.9, 0.99}) {
        Slab slab;
        slab.albedo = albedo;
        slab.tau = 16;
        // Over black, 16 mean free paths of albedo .99 lose 0.4 % of the light.
        EXPECT_TRUE(slab.radiance().near(semiInfinite(albedo, 1, 1), 0.006)) << "albedo " << albedo;
    }
}

TEST(Slab, ObliqueViewAndLight) {
    for (const double mu0 : {0.8, 0.5, 0.25}) {
        Slab slab;
        slab.albedo = 0.9;
        slab.tau = 12;
        slab.viewCosine = 0.5;
        slab.lightCosine = mu0;
        EXPECT_TRUE(slab.radiance().near(semiInfinite(0.9, 0.5, mu0), 0.01)) << "mu0 " << mu0;
    }
}

// Half a mean free path a voxel: the field is linear within voxels, not constant, or this would be off by 3 %.
TEST(Slab, CoarseVoxels) {
    Slab slab;
    slab.albedo = 0.99;
    slab.tau = 16;
    slab.layersPerMm = 2;
    slab.viewCosine = 0.5;
    EXPECT_TRUE(slab.radiance().near(semiInfinite(0.99, 0.5, 1), 0.015));
}

// A shell over a core of its own medium is semi-infinite too: tests transmitted light, core balance, backlight and the
// core's radiance at the end of the march. The split of direct and diffuse light is good to 0.6 % (THEORY 1.5).
TEST(Slab, ShellOverCoreOfItsOwnMedium) {
    for (const double albedo : {0.9, 0.99}) {
        Slab slab;
        slab.albedo = albedo;
        slab.coreAlbedo = albedo;
        slab.tau = 2;
        EXPECT_TRUE(slab.radiance().near(semiInfinite(albedo, 1, 1), 0.015)) << "albedo " << albedo;
    }
}

// Nothing but single scattering is left when the tables are zero and the core is black.
TEST(Slab, TablesSetToZero) {
    Slab slab;
    slab.tables = silencedTable;
    slab.albedo = 0.9;
    slab.tau = 2;
    Slab::Measured r = slab.radiance();
    r.table = 0;
    EXPECT_TRUE(r.near(singleScattering(0.9, 2, 1, 1), 1e-3));
    // ... and with them the image is brighter by multiple scattering, far more than this.
    Slab full;
    full.albedo = 0.9;
    full.tau = 2;
    EXPECT_GT(full.radiance().mean, 1.5 * r.mean);
}

// A black core takes away what the closed form of the layered balance says.
TEST(Slab, CoreSetToBlack) {
    Slab lit;
    lit.albedo = 0.9;
    lit.coreAlbedo = 0.99;
    lit.tau = 1;
    Slab black = lit;
    black.coreAlbedo = 0;
    const Slab::Measured with = lit.radiance(), without = black.radiance();

    // B = [D R_c(1) + (T - D) R_cd] / (1 - R_cd R_sd) from the table's own column, then the radiance that reaches the
    // camera: B / pi through the layer, plus what the layer scatters of it.
    Progress progress;
    const auto volume = std::make_shared<const BaseVolume>(readBaseVolume(lit.volumePath()));
    const StfTable& table = *Slab::sharedTables(volume, lit.transportOptions(), progress, {});
    const HFunction h(0.01);
    const DirectionWeights normal = table.directions.weights({0, 0, 1});
    const double direct = double(table.direct->rgb(0, normal).y),
                 transmitted = double(table.transmitted->rgb(0, normal).y);
    const double back = double(table.reflectedBelow[0].y);
    EXPECT_NEAR(direct, std::exp(-1.0), 1e-3);
    const double b = (direct * h.reflectance(1) + (transmitted - direct) * h.diffuseReflectance()) /
                     (1 - h.diffuseReflectance() * back);
    double scattered = 0;
    const double step = 1.0 / table.size.z;
    for (int z = 0; z < table.size.z; ++z) {
        scattered += 0.9 * double(table.backlight->node(std::size_t(z), 0, 1)) / (4 * kPi) *
                     (std::exp(-z * step) - std::exp(-(z + 1) * step));
    }
    const double predicted = b / kPi * (std::exp(-1.0) + scattered);
    EXPECT_GT(predicted, 0.2 * with.mean);
    const Slab::Measured difference{with.mean - without.mean, std::hypot(with.error, without.error), 0};
    EXPECT_TRUE(difference.near(predicted, 0.01));
}

// Albedo 1 in a uniform environment: every pixel has the radiance of the environment, whatever the index.
TEST(Slab, WhiteFurnace) {
    for (const double ior : {1.0, 1.3, 1.5}) {
        for (const double tau : {1.0, 4.0}) {
            Slab slab;
            slab.lit = Slab::Lit::Dome;
            slab.ior = ior;
            slab.albedo = 1;
            slab.coreAlbedo = 1;
            slab.tau = tau;
            slab.viewCosine = tau > 2 ? 1 : 0.4;
            slab.settings.samples = 256;
            EXPECT_TRUE(slab.radiance().near(1, 0.01)) << "index " << ior << ", tau " << tau;
        }
    }
}

// The same where the surface is cut into: voxels that are partly material hold the fluence inside it, and none is read
// where there is none. With an index, light and camera rays go through the relief's surface.
TEST(Slab, WhiteFurnaceWithRelief) {
    for (const double ior : {1.0, 1.4}) {
        for (const double mu : {1.0, 0.5}) {
            Slab slab;
            slab.relief = true;
            slab.lit = Slab::Lit::Dome;
            slab.quality = 0.1f;
            slab.ior = ior;
            slab.g = 0.5;
            slab.albedo = 1;
            slab.coreAlbedo = 1;
            slab.viewCosine = mu;
            slab.settings.samples = 256;
            EXPECT_TRUE(slab.radiance().near(1, 0.015)) << "index " << ior << ", mu " << mu;
            EXPECT_TRUE(slab.messages.empty());
        }
    }
}

// Beer-Lambert: an absorbing shell shows its core through exp(-tau / mu), and nothing else.
TEST(Slab, AbsorbingShellOverCore) {
    Slab slab;
    slab.albedo = 0;
    slab.coreAlbedo = 0.9;
    slab.tau = 1;
    slab.viewCosine = 0.6;
    const HFunction h(0.1);
    Slab::Measured r = slab.radiance();
    r.table = 0;
    EXPECT_TRUE(r.near(std::exp(-1.0) * h.reflectance(1) / kPi * std::exp(-1.0 / 0.6), 5e-3));
    bool walked = false;
    for (const PlanEntry& e : slab.plan) {
        walked = walked || (e.stage == "transport" && e.runs);
    }
    EXPECT_FALSE(walked) << "nothing scatters: no walks";
}

TEST(Slab, ImageDoesNotDependOnThreads) {
    for (const double ior : {1.0, 1.5}) {
        Slab slab;
        slab.quality = 0.05f;
        slab.coreAlbedo = 0.9;
        slab.ior = ior;
        slab.lit = Slab::Lit::Dome;
        slab.settings.samples = 8;
        slab.settings.threads = 1;
        const std::vector<float> one = slab.render();
        slab.settings.threads = 2;
        EXPECT_EQ(one, slab.render());
        slab.settings.seed = 1;
        EXPECT_NE(one, slab.render());
    }
}

TEST(Slab, TermsSumToColor) {
    for (const double ior : {1.0, 1.5}) {
        Slab slab;
        slab.quality = 0.05f;
        slab.coreAlbedo = 0.9;
        slab.ior = ior;
        slab.lit = Slab::Lit::Dome;
        slab.settings.samples = 16;
        const std::vector<float> color = slab.render(), single = slab.render(Aov::StfSingle);
        const std::vector<float> multiple = slab.render(Aov::StfMultiple), core = slab.render(Aov::StfCore);
        const std::vector<float> reflection = slab.render(Aov::StfReflection);
        // Fresnel's reflectance at normal incidence, (n - 1)^2 / (n + 1)^2.
        const double mirrored = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1));
        for (std::size_t i = 0; i < std::size_t(Slab::kWidth * Slab::kWidth); ++i) {
            const float sum = single[i * 3] + multiple[i * 3] + core[i * 3] + reflection[i * 3];
            EXPECT_NEAR(color[i * 4], sum, 1e-6f);
            EXPECT_NEAR(reflection[i * 3], mirrored, 1e-6);
            EXPECT_NEAR(color[i * 4 + 3], 1, 1e-6f);
        }
    }
}

} // namespace
} // namespace stf::test
