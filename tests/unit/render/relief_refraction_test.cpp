// SPDX-License-Identifier: Apache-2.0
// Shells whose relief refracts: closed forms, the flat top, and walks by reciprocity.
#include "stfLib/optics/fresnel.h"
#include "tests/unit/render/slab_fixture.h"
#include "tests/unit/support/files.h"
#include "tests/unit/transport/reliefs.h"
#include "tests/unit/transport/walks.h"

#include <algorithm>

namespace stf::test {
namespace {

constexpr int kColumns = 16;
constexpr double kVoxelMm = 0.1, kTileMm = kColumns * kVoxelMm;

// A tile under a height field along x; depths in voxels.
BaseVolume under(const Relief& relief, int layers, double kappa, double albedo, double n, double g = 0) {
    BaseVolume v = homogeneous({kColumns, 2, layers}, Vec3d(kVoxelMm), Rgb(float(kappa)), Rgb(float(albedo)), float(g));
    relief.carve(v);
    return withIndex(std::move(v), n);
}
Relief plane(double depth) {
    Relief r;
    r.depth.assign(kColumns, depth);
    return r;
}

// A quad of this tile in a white dome, seen over one tile or a whole number of them along both axes.
Slab in(const BaseVolume& volume) {
    Slab slab;
    slab.lit = Slab::Lit::Dome;
    slab.shape = [volume](BaseVolume& v) { v = volume; };
    slab.viewMm = kTileMm;
    slab.quality = 0.05f;
    slab.settings.samples = 256;
    return slab;
}

// What the flat top's tests compare with, through a plane half a millimetre below the top.
TEST(ReliefRefraction, PlaneBelowTheTopIsAFlatTop) {
    const nlohmann::json slabs = reference("slab_cases.json");
    double exact = 0;
    for (const auto& c : slabs["cases"]) {
        if (c["tau"] == 400 && c["albedo"] == 0.9 && c["g"] == 0 && c["n"] == 1.5) {
            exact = double(c["normal"]["R_total"]) - double(c["normal"]["R_specular"]);
        }
    }
    ASSERT_GT(exact, 0.1);
    Slab slab = in(under(plane(5), 125, 1, 0.9, 1.5));
    slab.lit = Slab::Lit::Distant;
    slab.quality = 0.02f;
    EXPECT_TRUE(slab.reflectance().near(exact, 0.01));
}

// Shifted by a depth, the flat top's radiance to the noise of both: the plane lies within a layer and between layers.
TEST(ReliefRefraction, PlaneEqualsTheFlatTop) {
    for (const double mu : {1.0, 0.5}) {
        Slab flat;
        flat.tau = 2;
        flat.ior = 1.5;
        flat.coreAlbedo = 0.9;
        flat.viewCosine = mu;
        flat.lightCosine = 0.6;
        const Slab::Measured expected = flat.radiance();
        for (const double depth : {3.0, 2.5}) {
            Slab slab = in(under(plane(depth), int(20 + depth), 1, 0.9, 1.5));
            slab.lit = Slab::Lit::Distant;
            slab.coreAlbedo = 0.9;
            slab.viewCosine = mu;
            slab.lightCosine = 0.6;
            slab.quality = 0.01f;
            // Half a layer less of the medium, of the same kind as the core.
            EXPECT_TRUE(slab.radiance().near(expected.mean, expected.table + 0.01 + (depth == 2.5 ? 0.01 : 0)))
                << "mu " << mu << ", depth " << depth;
        }
    }
}

// A groove of 45 degrees in black glass, seen from above, shows what both of its sides mirror one after the other.
TEST(ReliefRefraction, GrooveMirrorsTwice) {
    const double n = 2.4, once = fresnelSplit<double>(std::sqrt(0.5), n).reflectance;
    Relief relief = groove(kColumns, 2, 10);
    std::rotate(relief.depth.begin(), relief.depth.begin() + kColumns / 4, relief.depth.end());
    Slab slab = in(under(relief, 20, 200, 0, n));
    slab.viewMm = kVoxelMm; // amid a side, far from ridge and valley
    slab.settings.samples = 512;
    EXPECT_TRUE(slab.radiance().near(once * once, 1e-3));
    // All of it is reflection.
    const std::vector<float> reflection = slab.render(Aov::StfReflection), color = slab.render();
    for (std::size_t i = 0; i < reflection.size() / 3; ++i) {
        ASSERT_EQ(reflection[3 * i], color[4 * i]);
    }
}

// A white dome over a tile that absorbs nothing is all there is to see, whatever interfaces do.
TEST(ReliefRefraction, WhiteFurnace) {
    for (const double n : {1.3, 1.5, 0.8}) {
        for (const double mu : {1.0, 0.5, 0.125}) {
            Slab slab = in(under(waves(kColumns, 5, 3), 20, 4, 1, n, 0.3));
            slab.coreAlbedo = 1;
            slab.quality = 0.1f;
            slab.viewCosine = mu;
            EXPECT_TRUE(slab.radiance().near(1, 0.015)) << "index " << n << ", mu " << mu;
            EXPECT_TRUE(slab.messages.empty()) << slab.messages.front();
        }
    }
}

// Light that comes from a direction and light that is seen from there take the same ways: under a white dome, radiance
// towards a viewer is the reflectance of parallel light from the viewer. Walks know no camera and no table.
TEST(ReliefRefraction, ReciprocalToWalks) {
    for (const double n : {1.3, 1.5}) {
        const BaseVolume v = under(waves(kColumns, 6, 4), 30, 3, 0.9, n, 0.3);
        const TileMedium medium(v, TransportForm::Classic);
        for (const double mu : {1.0, 0.5, 0.25}) {
            WalkSource light;
            light.towardsLight = {0, -float(std::sqrt(1 - mu * mu)), float(mu)};
            const Estimate walked = estimate(walkBatches(medium, light, 32, 4000, totalsRequest(0, 7)),
                                             [](const WalkTally& b) { return reflectance(b); });
            Slab slab = in(v);
            slab.viewCosine = mu;
            slab.settings.samples = 64;
            // Pixels differ by what they see: the error is that of repetitions.
            Slab::Measured r;
            std::vector<double> images;
            for (int seed = 1; seed <= 8; ++seed) {
                slab.settings.seed = std::uint64_t(seed);
                r = slab.radiance();
                images.push_back(r.mean);
            }
            r.mean = estimate(images).mean;
            r.error = std::hypot(estimate(images).sigma, walked.sigma);
            EXPECT_TRUE(r.near(walked.mean, 0.01)) << "index " << n << ", mu " << mu;
        }
    }
}

// Total reflection, grazing views and clear ridges: nothing but numbers, and never more than there is light.
TEST(ReliefRefraction, StaysFiniteWhereItIsHard) {
    for (const double n : {0.5, 1.0001, 2.4}) {
        for (const double kappa : {0.0, 50.0}) {
            for (const double mu : {0.3, 0.02}) {
                Slab slab = in(under(stairs(kColumns, 1, 8), 12, kappa, 0.5, n));
                slab.viewMm = 0.2;
                slab.settings.samples = 16;
                slab.quality = 0.3f;
                slab.viewCosine = mu;
                for (const float x : slab.render()) {
                    ASSERT_TRUE(std::isfinite(x)) << n << " " << kappa << " " << mu;
                    ASSERT_GE(x, 0);
                }
                EXPECT_LE(slab.radiance().mean, 1.02) << n << " " << kappa << " " << mu;
            }
        }
    }
}

} // namespace
} // namespace stf::test
