// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/patch_offsets.h"

#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

TEST(PatchOffsets, KeepReflectanceInBalanceOnASurfaceOfFewPatches) {
    // A torus of about a tile's area, in a sample that is dark on one side of the tile and bright on the other: what each
    // of a few patches shows weighs.
    BaseVolume v = waves(48);
    for (std::size_t i = 0; i < v.albedo.size(); ++i) {
        v.albedo[i] = Rgb(float(1 - 0.02 * std::exp(1.2 * std::cos(2 * pi * double(i % 48) / 48))));
    }
    const Synthesis s = synthesized(sampleSurface(refinedOf(torus(6, 2.5, 64, 32)), 0.5, 1, 1000000, {}), v);
    double mean = 0;
    for (const Rgb& r : s.exemplar.response) {
        mean += double(r.y) / double(s.exemplar.response.size());
    }
    // Reflectance of what the chart nearest to each vertex shows, over the sample's, less 1; rms over seeds.
    const auto off = [&](double balance) {
        double sum = 0;
        for (std::uint64_t seed = 0; seed < 6; ++seed) {
            OffsetOptions options;
            options.seed = seed;
            options.balance = balance;
            Progress progress;
            const std::vector<Vec2f> offset = chooseOffsets(s.graph, s.cover, s.exemplar, 1, options, progress);
            double shown = 0;
            for (std::size_t i = 0; i < s.graph.size(); ++i) {
                int best = s.cover.first[i];
                for (int e = best; e < s.cover.first[i + 1]; ++e) {
                    best = s.cover.remoteness[std::size_t(e)] < s.cover.remoteness[std::size_t(best)] ? e : best;
                }
                const Vec2f c =
                    s.cover.coord[std::size_t(best)] + offset[std::size_t(s.cover.chart[std::size_t(best)])];
                const int x = s.exemplar.wrapX(int(std::floor(double(c.x) / s.exemplar.texelMm.x))),
                          y = s.exemplar.wrapY(int(std::floor(double(c.y) / s.exemplar.texelMm.y)));
                shown += double(s.exemplar.response[std::size_t(y * s.exemplar.width + x)].y);
            }
            const double d = shown / double(s.graph.size()) / mean - 1;
            sum += d * d / 6;
        }
        return std::sqrt(sum);
    };
    const double balanced = off(1), free = off(0);
    EXPECT_LT(balanced, 0.5 * free);
    EXPECT_LT(balanced, 0.02);
}
