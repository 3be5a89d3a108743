// SPDX-License-Identifier: Apache-2.0
// A flat shell that refracts at its top: closed forms and adding-doubling.
#include "stfLib/optics/fresnel.h"
#include "tests/unit/render/slab_fixture.h"
#include "tests/unit/support/files.h"

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

std::shared_ptr<const StfTable> onlySingle(const std::shared_ptr<const BaseVolume>& volume,
                                           const TransportOptions& options, Progress& progress,
                                           const MessageSink& messages) {
    StfTable t = *Slab::sharedTables(volume, options, progress, messages);
    t.multiple = FactoredField();
    return std::make_shared<const StfTable>(std::move(t));
}

// R of a normally lit slab with and without its mirror image.
struct Reflected {
    double all = 0, specular = 0, diffuse = 0;
};
Reflected slabCase(double tau, double albedo, double g, double n) {
    const nlohmann::json slabs = reference("slab_cases.json");
    for (const auto& c : slabs["cases"]) {
        if (c["tau"] == tau && c["albedo"] == albedo && c["g"] == g && c["n"] == n) {
            return {c["normal"]["R_total"], c["normal"]["R_specular"], c["diffuse"]["R_total"]};
        }
    }
    ADD_FAILURE() << "no such case";
    return {};
}

// L = (1 - F_o) / n^2  a (1 - F_i) (mu_i / t_i) t_i / (4 pi (t_o + t_i)) (1 - exp(-tau (1/t_o + 1/t_i))), t the cosines
// inside.
TEST(SlabRefraction, SingleScattering) {
    for (const double view : {1.0, 0.3}) {
        for (const double light : {1.0, 0.5}) {
            Slab slab;
            slab.tables = onlySingle;
            slab.quality = 0.1f;
            slab.ior = 1.5;
            slab.viewCosine = view;
            slab.lightCosine = light;
            const auto o = fresnelSplit<double>(view, 1.5), i = fresnelSplit<double>(light, 1.5);
            const double exact = (1 - o.reflectance) / (1.5 * 1.5) * 0.9 * (1 - i.reflectance) * light /
                                 (4 * kPi * (o.cosT + i.cosT)) * (1 - std::exp(-2 / o.cosT - 2 / i.cosT));
            Slab::Measured r = slab.radiance();
            r.table = 0;
            EXPECT_TRUE(r.near(exact, 1e-3)) << "view " << view << ", light " << light;
        }
    }
}

// Thick over black, and thin over a core of its own medium: the core has no boundary of its own (DESIGN 3.9).
TEST(SlabRefraction, SemiInfinite) {
    const Reflected exact = slabCase(400, 0.9, 0, 1.5);
    Slab thick;
    thick.albedo = 0.9;
    thick.tau = 12;
    thick.ior = 1.5;
    EXPECT_TRUE(thick.reflectance().near(exact.all - exact.specular, 0.01)) << "over black";
    Slab thin = thick;
    thin.tau = 2;
    thin.coreAlbedo = 0.9;
    EXPECT_TRUE(thin.reflectance().near(exact.all - exact.specular, 0.05)) << "over its own medium";
    thin.lit = Slab::Lit::Dome; // what the surface mirrors is in the image
    EXPECT_TRUE(thin.reflectance().near(exact.diffuse, 0.05)) << "diffuse light";
}

// Strong absorption leaves little but the first few collisions, where a linear phase function is worst: +6 % with and
// without an index.
TEST(SlabRefraction, ForwardScattering) {
    const Reflected exact = slabCase(100, 0.9, 0.9, 1.33);
    Slab slab;
    slab.albedo = 0.9;
    slab.g = 0.9;
    slab.tau = 30; // exp(-2 * 30 * 0.24): as good as 100
    slab.layersPerMm = 4;
    slab.ior = 1.33;
    EXPECT_TRUE(slab.reflectance().near(exact.all - exact.specular, 0.08));
}

// The balance of light between shell and core loses nothing where nothing absorbs, and the image keeps it: a furnace of
// any albedo below 1 is darker, one of albedo 1 is not (Slab.WhiteFurnace).
TEST(SlabRefraction, GreyFurnaceIsDarker) {
    Slab slab;
    slab.lit = Slab::Lit::Dome;
    slab.quality = 0.02f;
    slab.ior = 1.5;
    slab.coreAlbedo = 1;
    slab.albedo = 0.99;
    const Slab::Measured r = slab.radiance();
    EXPECT_LT(r.mean + 4 * r.error, 1 - r.table);
    EXPECT_GT(r.mean, 0.5);
}

} // namespace
} // namespace stf::test
