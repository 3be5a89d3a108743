// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/tile_medium.h"

#include "stfLib/base/random.h"
#include "stfLib/optics/fresnel.h"
#include "tests/unit/transport/reliefs.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

const Vec3i kSize(4, 3, 5);
const Vec3d kVoxelMm(0.5, 0.8, 0.3);

BaseVolume plain(float kappa = 2, float albedo = 0.9f, float g = 0.6f) {
    return homogeneous(kSize, kVoxelMm, Rgb(kappa), Rgb(albedo), g);
}

TEST(TileMedium, CoefficientsOfBothForms) {
    const BaseVolume v = plain();
    const TileMedium classic(v, TransportForm::Classic), scaled(v, TransportForm::DE1);
    EXPECT_EQ(classic.voxel(7).extinction, Rgb(2.0f));
    EXPECT_EQ(classic.voxel(7).keep, 1);
    EXPECT_EQ(classic.voxel(7).gScaled, 0) << "published form: isotropic multiple scattering";
    EXPECT_EQ(classic.voxel(7).g, 0.6f);
    EXPECT_FALSE(classic.wantsFlux());
    const TileMedium::Voxel& s = scaled.voxel(7);
    EXPECT_NEAR(s.extinction.x, 2 * (1 - 0.9f * 0.36f), 1e-6f);
    EXPECT_NEAR(s.scattering.x, 1.8f, 1e-6f) << "of the true medium";
    EXPECT_NEAR(s.keep, 0.64f, 1e-6f);
    EXPECT_NEAR(s.gScaled, 0.375f, 1e-6f);
    EXPECT_NEAR(s.extinction.x - s.scattering.x * s.keep, 0.2f, 1e-6f) << "the absorption is the true one";
    EXPECT_TRUE(scaled.wantsFlux());
    EXPECT_FALSE(TileMedium(plain(2, 0.9f, 0), TransportForm::DE1).wantsFlux());
    EXPECT_TRUE(TileMedium(plain(2, 0.9f, -0.5f), TransportForm::DE1).wantsFlux());
}

TEST(TileMedium, KnowsWhatItHolds) {
    BaseVolume v = plain();
    const TileMedium grey(v, TransportForm::DE1);
    EXPECT_TRUE(grey.greyExtinction());
    EXPECT_EQ(grey.channelLike(1), 0);
    EXPECT_EQ(grey.channelLike(2), 0);
    EXPECT_TRUE(grey.scatters());
    EXPECT_FALSE(grey.emits());
    EXPECT_FALSE(grey.hasSurface());
    EXPECT_FALSE(grey.refracts());
    EXPECT_EQ(grey.fill(3), 1);
    EXPECT_FALSE(TileMedium(plain(2, 0), TransportForm::DE1).scatters());
    EXPECT_FALSE(TileMedium(plain(0, 1), TransportForm::DE1).scatters());

    v.albedo[5].z = 0.5f; // where g is not 0, the scaled extinction depends on the albedo
    EXPECT_FALSE(TileMedium(v, TransportForm::DE1).greyExtinction());
    const TileMedium classic(v, TransportForm::Classic);
    EXPECT_TRUE(classic.greyExtinction());
    EXPECT_EQ(classic.channelLike(1), 0);
    EXPECT_EQ(classic.channelLike(2), 2);
    v.extinction[6].y = 1;
    const TileMedium coloured(v, TransportForm::Classic);
    EXPECT_FALSE(coloured.greyExtinction());
    EXPECT_EQ(coloured.channelLike(1), 1);

    v = plain();
    v.emission.assign(v.voxelCount(), Rgb(0.0f));
    EXPECT_FALSE(TileMedium(v, TransportForm::DE1).emits());
    v.emission[2] = Rgb(0, 1, 0);
    const TileMedium glowing(v, TransportForm::DE1);
    EXPECT_TRUE(glowing.emits());
    EXPECT_EQ(glowing.channelLike(1), 1) << "alike but for the emission";
    EXPECT_EQ(glowing.channelLike(2), 0);

    v = plain();
    v.ior.assign(v.voxelCount(), 1.0f);
    EXPECT_FALSE(TileMedium(v, TransportForm::DE1).refracts());
    v.ior.assign(v.voxelCount(), 1.4f);
    const TileMedium glass(v, TransportForm::DE1, true);
    EXPECT_TRUE(glass.refracts());
    EXPECT_TRUE(glass.openBottom());
    EXPECT_EQ(glass.ior({100, -100, 0}), 1.4f);
    v.ior[v.index(1, 2, 3)] = 1.6f;
    const TileMedium mixed(v, TransportForm::DE1);
    EXPECT_EQ(mixed.ior({1.5f + 4, 2.5f - 3, 3.5f}), 1.6f);
    EXPECT_EQ(mixed.ior({2.5f, 2.5f, 3.5f}), 1.4f);
    EXPECT_EQ(mixed.ior({1.5f, 2.5f, 5}), 1.4f) << "the bottom belongs to the last layer";
}

TEST(TileMedium, VoxelsCutByASurfaceAreMadeOfWhatIsInside) {
    BaseVolume v = plain(2, 0.5f);
    waves(4, 2, 1).carve(v);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        if (v.surface[i] >= 0) {
            v.extinction[i] = Rgb(0.0f); // as makers of volumes leave it
        }
    }
    v.ior.assign(v.voxelCount(), 1.0f);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.ior[i] = v.surface[i] < 0 ? 1.5f : 1.0f;
    }
    const TileMedium m(v, TransportForm::Classic);
    EXPECT_TRUE(m.hasSurface());
    EXPECT_TRUE(m.refracts());
    int cut = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const float fill = m.fill(i);
        EXPECT_EQ(m.voxel(i).extinction, Rgb(fill > 0 ? 2.0f : 0.0f));
        cut += fill > 0 && fill < 1;
    }
    EXPECT_GT(cut, 10);
    EXPECT_EQ(m.ior({0, 0, 0}), 1.5f) << "the index of nothing is not asked for: uniform";
}

TEST(TileMedium, OpticalDepthIsTheSumOverTheLine) {
    BaseVolume v = plain();
    CounterRng rng(1, 0);
    for (Rgb& k : v.extinction) {
        k = Rgb(rng.uniform(), 0, 3 * rng.uniform());
    }
    const Relief relief = waves(4, 1.8, 1.2);
    for (bool carved : {false, true}) {
        if (carved) {
            v.extinction.assign(v.voxelCount(), Rgb(0.7f, 0, 1.9f)); // cut voxels would take their neighbours'
            relief.carve(v);
        }
        const TileMedium m(v, TransportForm::Classic);
        for (int i = 0; i < 200; ++i) {
            const Vec3f p{4 * rng.uniform(), 3 * rng.uniform(), 5 * rng.uniform()};
            const Vec3f towards = normalize(Vec3f(rng.uniform() - 0.5f, rng.uniform() - 0.5f, 0.1f + rng.uniform()));
            Vec3d sum(0.0);
            const int steps = 20000;
            const double length = double(p.z) * kVoxelMm.z / double(towards.z), dt = length / steps;
            for (int k = 0; k < steps; ++k) {
                const double t = (k + 0.5) * dt;
                const double x = double(p.x) + t * double(towards.x) / kVoxelMm.x,
                             y = double(p.y) + t * double(towards.y) / kVoxelMm.y,
                             z = double(p.z) - t * double(towards.z) / kVoxelMm.z;
                if (carved && relief.at(x) >= std::min(4.5, std::max(0.5, z))) {
                    continue;
                }
                const auto cell = [](double c, int n) { return TileTracer::wrap(int(std::floor(c)), n); };
                sum += Vec3d(v.extinction[v.index(cell(x, 4), cell(y, 3), std::min(4, int(z)))]) * dt;
            }
            const Rgb depth = m.opticalDepth(p, towards);
            const double tolerance = 2e-3 + 4 * dt;
            EXPECT_NEAR(double(depth.x), sum.x, tolerance);
            EXPECT_EQ(depth.y, 0);
            EXPECT_NEAR(double(depth.z), sum.z, 3 * tolerance);
        }
    }
}

TEST(TileMedium, UncollidedLightBelowAFlatTop) {
    BaseVolume v = plain(1.5f);
    for (float n : {1.0f, 1.5f, 0.9f}) {
        v.ior.assign(v.voxelCount(), n);
        const TileMedium m(v, TransportForm::Classic);
        for (float mu : {1.0f, 0.6f, 0.1f}) {
            const Vec3f towards{0.8f * std::sqrt(1 - mu * mu), -0.6f * std::sqrt(1 - mu * mu), mu};
            const UncollidedLight l = m.uncollided({0.3f, 2.2f, 3}, towards);
            const FresnelSplit split = fresnel(mu, n);
            if (split.cosT == 0) {
                EXPECT_EQ(l.fraction, Rgb(0.0f)) << "reflected in total";
                continue;
            }
            // Flux through the top is kept: (1 - F) mu per area, and fluence is flux over cosine.
            const float expected = (1 - split.reflectance) * mu / split.cosT * std::exp(-1.5f * 3 * 0.3f / split.cosT);
            EXPECT_NEAR(l.fraction.x, expected, 1e-5f * (1 + expected));
            EXPECT_NEAR(length(l.towards), 1, 1e-5f);
            EXPECT_NEAR(l.towards.z, split.cosT, 1e-5f);
            EXPECT_NEAR(l.towards.x, towards.x / n, 1e-5f);
            EXPECT_NEAR(l.towards.y, towards.y / n, 1e-5f);
        }
        EXPECT_EQ(m.uncollided({0, 0, 1}, {1, 0, 0}).fraction, Rgb(0.0f));
        EXPECT_EQ(m.uncollided({0, 0, 1}, {0, 0.6f, -0.8f}).fraction, Rgb(0.0f));
    }
}

// Between two faces light goes to and fro: what flows down less what flows up is what is absorbed further down and
// what leaves.
TEST(TileMedium, UncollidedLightAboveAnOpenBottom) {
    BaseVolume v = plain(0.4f);
    v.ior.assign(v.voxelCount(), 1.5f);
    const TileMedium open(v, TransportForm::Classic, true), matched(v, TransportForm::Classic);
    for (float mu : {1.0f, 0.4f, 0.02f}) {
        const Vec3f towards{std::sqrt(1 - mu * mu), 0, mu};
        const FresnelSplit split = fresnel(mu, 1.5f);
        const float f = split.reflectance, whole = 0.4f * 1.5f / split.cosT, e = std::exp(-2 * whole);
        EXPECT_EQ(matched.uncollided({1, 1, 2}, towards).reflected, Rgb(0.0f));
        const UncollidedLight bottom = open.uncollided({1, 1, 5}, towards);
        const float leaves = (1 - f) * (1 - f) * std::exp(-whole) / (1 - f * f * e);
        EXPECT_NEAR(bottom.fraction.x * split.cosT / mu * (1 - f), leaves, 1e-5f);
        EXPECT_NEAR(bottom.reflected.x / bottom.fraction.x, f, 1e-5f);
        const UncollidedLight top = open.uncollided({1, 1, 0}, towards);
        const float back = f + (1 - f) * (1 - f) * f * e / (1 - f * f * e);
        EXPECT_NEAR(f + (1 - f) * top.reflected.x * split.cosT / mu, back, 1e-5f);
        EXPECT_NEAR(length(bottom.towards), 1, 1e-5f);
    }
}

} // namespace
