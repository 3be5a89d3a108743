// SPDX-License-Identifier: Apache-2.0
// Marches through blends against what a blend is: a volume of its own, with a table of its own.
#include "stfLib/render/tile_march.h"
#include "stfLib/transport/precompute.h"
#include "tests/unit/support/smooth_noise.h"
#include "tests/unit/support/statistics.h"

#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr int kSide = 24, kDepth = 8;

BaseVolume randomSample() {
    BaseVolume v;
    v.size = {kSide, kSide, kDepth};
    v.voxelMm = Vec3d(0.1);
    for (float n : smoothNoise(v.size, v.voxelMm, 0.12, 7)) {
        const float k = 4 * std::exp(8 * n);
        v.extinction.push_back(Rgb(k));
        v.albedo.push_back(Rgb(0.95f, 0.8f, 0.8f - 0.2f * std::tanh(8 * n)));
    }
    return v;
}

StfTable tableOf(const BaseVolume& v) {
    TransportOptions options;
    options.quality = 0.03;
    options.form = TransportForm::Classic;
    Progress progress;
    return precompute(v, options, progress, {});
}

Vec3f perMm(const BaseVolume& v, const Vec3f& viewer) {
    return {float(-viewer.x / v.voxelMm.x), float(-viewer.y / v.voxelMm.y), float(viewer.z / v.voxelMm.z)};
}

struct Seen {
    Estimate color[3];
};

Seen radiance(TileMarch& march, const BaseVolume& v, const MarchLight& light, const Vec3f& viewer,
              const BlendPlace* place) {
    std::vector<double> values[3];
    for (int i = 0; i < 30000; ++i) {
        PixelSampler sampler(11, 3, std::uint32_t(i));
        const Vec2f at = sampler.next2d();
        march.begin(sampler);
        march.setFrame(&light, 1, viewer);
        if (place) {
            march.setBlend(*place);
        }
        march.segment({at.x * kSide, at.y * kSide, 0}, perMm(v, viewer), float(v.extentMm().z) / viewer.z);
        const TileRadiance r = march.finish();
        for (int c = 0; c < 3; ++c) {
            values[c].push_back(double(r.single[c] + r.multiple[c]));
        }
    }
    return {{estimate(values[0]), estimate(values[1]), estimate(values[2])}};
}

// Two whole-voxel shifts with fixed weights: the blend repeats as the tile does.
BlendPlace place(const std::array<float, 3>& weight) {
    BlendPlace p;
    p.origin = {Vec2f(7, 5), Vec2f(13, 17)};
    p.alongX = {Vec2f(1, 0), Vec2f(1, 0)};
    p.alongY = {Vec2f(0, 1), Vec2f(0, 1)};
    p.weight = weight;
    return p;
}

BaseVolume baked(const BaseVolume& v, const HistogramBlend& blend, const BlendPlace& place) {
    BaseVolume b = v;
    const auto column = [](int x, int y) { return std::size_t(x % kSide) + kSide * std::size_t(y % kSide); };
    for (int z = 0; z < kDepth; ++z) {
        for (int y = 0; y < kSide; ++y) {
            for (int x = 0; x < kSide; ++x) {
                const TileMedium::Voxel m =
                    blend.voxel({column(x, y), column(x + 7, y + 5), column(x + 13, y + 17)}, place, z);
                const std::size_t i = b.index(x, y, z);
                b.extinction[i] = m.extinction;
                for (int c = 0; c < 3; ++c) {
                    b.albedo[i][c] = std::min(1.0f, m.scattering[c] / m.extinction[c]);
                }
            }
        }
    }
    return b;
}

TEST(BlendedMarch, ShinesLikeTheBlendedVolume) {
    const BaseVolume v = randomSample();
    const TileMedium medium(v, TransportForm::Classic);
    const StfTable table = tableOf(v);
    const HistogramBlend blend(medium, &table, false);
    for (const std::array<float, 3>& weight : {std::array<float, 3>{0.5f, 0.5f, 0}, {0.4f, 0.35f, 0.25f}}) {
        const BlendPlace p = place(weight);
        const BaseVolume b = baked(v, blend, p);
        const TileMedium bakedMedium(b, TransportForm::Classic);
        const StfTable bakedTable = tableOf(b);
        TileMarch march(medium, table, &blend), reference(bakedMedium, bakedTable);
        for (const Vec3f& viewer : {Vec3f(0, 0, 1), normalize(Vec3f(0.6f, 0.3f, 0.6f))}) {
            const MarchLight light{normalize(Vec3f(-0.3f, 0.5f, 0.8f)), Rgb(1.0f), Rgb(1.0f)};
            const Seen mine = radiance(march, v, light, viewer, &p),
                       its = radiance(reference, b, light, viewer, nullptr);
            for (int c = 0; c < 3; ++c) {
                // Coefficients are the same; light in the table is not walked again. Beside the tables' own 3 %.
                EXPECT_NEAR(mine.color[c].mean, its.color[c].mean,
                            0.02 * its.color[c].mean + 4 * std::hypot(mine.color[c].sigma, its.color[c].sigma))
                    << weight[0] << ' ' << c;
            }
        }
    }
}

TEST(BlendedMarch, OnePlaceAloneIsTheTile) {
    const BaseVolume v = randomSample();
    const TileMedium medium(v, TransportForm::Classic);
    const StfTable table = tableOf(v);
    const HistogramBlend blend(medium, &table, false);
    TileMarch blended(medium, table, &blend), plain(medium, table);
    const MarchLight light{{0, 0, 1}, Rgb(1.0f), Rgb(1.0f)};
    const Vec3f viewer = normalize(Vec3f(0.6f, 0, 0.8f));
    const BlendPlace p = place({1, 0, 0});
    const Seen mine = radiance(blended, v, light, viewer, &p), its = radiance(plain, v, light, viewer, nullptr);
    for (int c = 0; c < 3; ++c) {
        // The same random numbers; coefficients come back through 128 quantiles.
        EXPECT_NEAR(mine.color[c].mean, its.color[c].mean, 0.003 * its.color[c].mean);
    }
}

TEST(BlendedMarch, KeepsTheLookOfTheSample) {
    // The scatter of radiance over the surface is that of the tile: a plain mean of two places would lose a third of
    // it.
    const BaseVolume v = randomSample();
    const TileMedium medium(v, TransportForm::Classic);
    const StfTable table = tableOf(v);
    const HistogramBlend blend(medium, &table, false);
    const auto contrast = [&](const HistogramBlend* b, const BlendPlace* p) {
        TileMarch march(medium, table, b);
        const MarchLight light{{0, 0, 1}, Rgb(1.0f), Rgb(1.0f)};
        const Vec3f viewer(0, 0, 1);
        double sum = 0, squares = 0;
        for (int column = 0; column < kSide * kSide; ++column) {
            double mean = 0;
            for (int i = 0; i < 64; ++i) {
                PixelSampler sampler(11, std::uint64_t(column), std::uint32_t(i));
                march.begin(sampler, {0, 0});
                march.setFrame(&light, 1, viewer);
                if (p) {
                    march.setBlend(*p);
                }
                march.segment({float(column % kSide) + 0.5f, float(column / kSide) + 0.5f, 0}, perMm(v, viewer),
                              float(v.extentMm().z));
                const TileRadiance r = march.finish();
                mean += double(r.single.y + r.multiple.y) / 64;
            }
            sum += mean / (kSide * kSide);
            squares += mean * mean / (kSide * kSide);
        }
        return std::sqrt(squares - sum * sum) / sum;
    };
    const BlendPlace p = place({0.5f, 0.5f, 0});
    const double own = contrast(nullptr, nullptr), mine = contrast(&blend, &p);
    EXPECT_NEAR(mine, own, 0.12 * own); // one tile of 576 columns, correlated over two: some 8 % of scatter
}

} // namespace
} // namespace stf::test
