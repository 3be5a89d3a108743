// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/histogram_blend.h"

#include "tests/unit/support/smooth_noise.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

// A random field with a skew distribution: two channels that vary together, and a layer where nothing varies.
BaseVolume randomSample() {
    BaseVolume v;
    v.size = {48, 40, 3};
    v.voxelMm = Vec3d(0.1);
    const std::vector<float> noise = smoothNoise(v.size, v.voxelMm, 0.2, 7);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const bool still = i / 1920 == 2;
        const float n = still ? 0.0f : 8 * noise[i];
        const float scattering = std::exp(n), absorption = 0.1f * std::exp(-0.5f * n);
        v.extinction.push_back(Rgb(scattering + absorption));
        v.albedo.push_back(Rgb(scattering / (scattering + absorption)));
        v.g.push_back(0.5f);
    }
    return v;
}

// Values of many blends of a layer: extinction and scattering of the first channel.
struct Values {
    std::vector<float> extinction, scattering;
};

Values blends(const HistogramBlend& blend, const Vec3i& size, int z, const std::array<float, 3>& weight) {
    Values out;
    CounterRng rng(9, std::uint64_t(z));
    BlendPlace place;
    place.weight = weight;
    const auto any = [&] { return std::size_t(rng.uniform() * float(size.x * size.y)); };
    for (int i = 0; i < 20000; ++i) {
        const std::array<std::size_t, 3> columns{any(), any(), any()};
        const TileMedium::Voxel v = blend.voxel(columns, place, z);
        out.extinction.push_back(v.extinction.x);
        out.scattering.push_back(v.scattering.x);
    }
    return out;
}

// Largest distance of two distribution functions.
double kolmogorovSmirnov(std::vector<float> a, std::vector<float> b) {
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    double worst = 0;
    std::size_t j = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        while (j < b.size() && b[j] <= a[i]) {
            ++j;
        }
        worst = std::max(worst, std::abs(double(i + 1) / double(a.size()) - double(j) / double(b.size())));
    }
    return worst;
}

TEST(HistogramBlend, KeepsTheDistributionOfCoefficients) {
    const BaseVolume v = randomSample();
    for (TransportForm form : {TransportForm::DE1, TransportForm::Classic}) {
        const TileMedium medium(v, form);
        const HistogramBlend blend(medium, nullptr, false);
        for (int z = 0; z < 2; ++z) {
            Values own;
            for (std::size_t i = 1920 * std::size_t(z); i < 1920 * std::size_t(z + 1); ++i) {
                own.extinction.push_back(medium.voxel(i).extinction.x);
                own.scattering.push_back(medium.voxel(i).scattering.x);
            }
            for (const std::array<float, 3>& w :
                 {std::array<float, 3>{1, 0, 0}, {0.5f, 0.5f, 0}, {0.34f, 0.33f, 0.33f}, {0.7f, 0.2f, 0.1f}}) {
                const Values mixed = blends(blend, v.size, z, w);
                // 1.63 / sqrt(n) at 1 % for the exemplar's own 1920 values (0.037), which are not independent of those
                // drawn from them: less is left.
                EXPECT_LT(kolmogorovSmirnov(mixed.extinction, own.extinction), 0.025) << w[0] << ' ' << z;
                EXPECT_LT(kolmogorovSmirnov(mixed.scattering, own.scattering), 0.025) << w[0] << ' ' << z;
            }
        }
    }
}

// Plain interpolation, for contrast: it would not keep the spread.
TEST(HistogramBlend, ABlendOfEqualPlacesIsThatPlace) {
    const BaseVolume v = randomSample();
    const TileMedium medium(v, TransportForm::DE1);
    const HistogramBlend blend(medium, nullptr, false);
    for (std::size_t i = 0; i < 1920; i += 97) {
        const TileMedium::Voxel one = blend.voxel({i, 3, 5}, BlendPlace(), 1);
        const TileMedium::Voxel& own = medium.voxel(1920 + i);
        EXPECT_NEAR(one.extinction.x, own.extinction.x, 0.03f * own.extinction.x);
        EXPECT_NEAR(one.scattering.x, own.scattering.x, 0.03f * own.scattering.x);
        EXPECT_FLOAT_EQ(one.keep, own.keep);
        EXPECT_FLOAT_EQ(one.gScaled, own.gScaled);
    }
}

TEST(HistogramBlend, ChannelsThatVaryTogetherStayTogether) {
    const BaseVolume v = randomSample();
    const TileMedium medium(v, TransportForm::Classic);
    const HistogramBlend blend(medium, nullptr, false);
    const Values mixed = blends(blend, v.size, 0, {0.4f, 0.3f, 0.3f});
    for (std::size_t i = 0; i < mixed.extinction.size(); i += 17) {
        // absorption = .1 / sqrt(scattering) at each voxel: a curve, which one axis follows to second order.
        const float absorption = mixed.extinction[i] - mixed.scattering[i];
        EXPECT_NEAR(absorption, 0.1f / std::sqrt(mixed.scattering[i]), 0.04f);
    }
}

TEST(HistogramBlend, ALayerWithoutChangeStaysAsItIs) {
    const BaseVolume v = randomSample();
    const HistogramBlend blend(TileMedium(v, TransportForm::Classic), nullptr, false);
    for (float k : blends(blend, v.size, 2, {0.4f, 0.3f, 0.3f}).extinction) {
        ASSERT_FLOAT_EQ(k, 1.1f);
    }
}

TEST(HistogramBlend, MeansOfTheTablesLayers) {
    const BaseVolume v = randomSample();
    const TileMedium medium(v, TransportForm::DE1);
    StfTable t;
    t.size = v.size;
    t.directions = DirectionSet(1, 1);
    std::vector<float> values;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        values.insert(values.end(), 3, float(i / 1920) + (i % 2 ? 0.25f : -0.25f));
    }
    t.multiple = FactoredField::single(values, 3);
    const HistogramBlend blend(medium, &t, true);
    ASSERT_EQ(blend.meanMultiple().items(), 3u);
    for (std::size_t z = 0; z < 3; ++z) {
        EXPECT_NEAR(blend.meanMultiple().node(z, 0, 1), float(z), 1e-6);
    }
    EXPECT_TRUE(blend.meanBacklight().empty());
}

TEST(HistogramBlend, RefusesARelief) {
    BaseVolume v = randomSample();
    v.surface.assign(v.voxelCount(), -0.1f);
    v.surface[5] = 0.1f;
    const TileMedium medium(v, TransportForm::DE1);
    EXPECT_THROW(HistogramBlend(medium, nullptr, false), Error);
}

} // namespace
} // namespace stf::test
