// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/quality.h"

#include "stfLib/base/random.h"
#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

/// A flat tile of n x n texels of 1 mm that shows the sample as it is, one vertex per texel corner; what is right of
/// `cut` texels is shifted by `shift` texels.
Synthesis flatTile(int n, int cut, int shift) {
    Synthesis s;
    Progress progress;
    const BaseVolume v = waves(n, 1);
    s.exemplar = makeExemplar(v, {}, progress);
    s.graph = surfaceGraph(refinedOf(rectangle(n, n, n, n)));
    s.directions.assign(s.graph.size(), Vec3f(1, 0, 0));
    s.steps = surfaceSteps(s.graph, s.directions, 1);
    const std::size_t count = s.graph.size();
    // One chart that is the plane.
    s.cover.charts.push_back({0, 100, false, 0, int(count)});
    s.cover.chart.assign(count, 0);
    s.cover.strain.assign(count, 0);
    s.cover.remoteness.assign(count, 0);
    for (std::size_t i = 0; i <= count; ++i) {
        s.cover.first.push_back(int(i));
    }
    s.labels.offset.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3f p = s.graph.points[i];
        s.cover.coord.push_back({p.x, p.y});
        s.labels.entry.push_back(int(i));
        s.labels.offset[i] = p.x > float(cut) + 0.5f ? Vec2f(float(shift), 0) : Vec2f(0, 0);
    }
    s.coords = healBreaks(s.graph, s.steps, s.cover, s.exemplar, s.labels, 1, progress);
    return s;
}

} // namespace

TEST(SynthesisQuality, OfTheSampleItselfIsPerfect) {
    const Synthesis s = flatTile(24, 24, 0);
    const ExemplarMap map = exemplarMap(s);
    const SynthesisQuality q = measure(s, map);
    EXPECT_EQ(q.samples, 25u * 25u);
    EXPECT_LT(q.neighbourhoodError, 1e-3);
    EXPECT_EQ(q.seamRate, 0);
    EXPECT_EQ(q.foldOvers, 0u);
    EXPECT_EQ(q.patches, 1u);
    EXPECT_LT(q.stretch, 1e-5);
    // Every texel is shown once; the rim's vertices count half, and twice.
    EXPECT_NEAR(q.reuseMax, 1, 1e-4);
    EXPECT_NEAR(q.reuseEntropy, 1, 1e-6);
    EXPECT_NEAR(q.patchLargest, 24 * 24, 1e-2);
    EXPECT_LT(q.ks, 0.02);
    EXPECT_LT(std::abs(q.deltaR), 0.002);
    // Coordinates and gradients of the map are those of the plane.
    for (std::size_t t = 0; t < s.graph.triangles.size(); ++t) {
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3f p = s.graph.points[std::size_t(s.graph.triangles[t][int(c)])];
            const double dx = double(map.cornerCoords[3 * t + c].x - p.x),
                         dy = double(map.cornerCoords[3 * t + c].y - p.y);
            EXPECT_NEAR(dx, 24 * std::round(dx / 24), 1e-4);
            EXPECT_NEAR(dy, 24 * std::round(dy / 24), 1e-4);
            EXPECT_LT(length(map.gradientX[3 * t + c] - Vec3f(1, 0, 0)), 1e-4f);
            EXPECT_LT(length(map.gradientY[3 * t + c] - Vec3f(0, 1, 0)), 1e-4f);
        }
    }
}

TEST(SynthesisQuality, CountsMirroredTrianglesButNoSliversBelowRounding) {
    Synthesis s = flatTile(24, 24, 0);
    ExemplarMap map = exemplarMap(s);
    for (std::size_t t : {7u, 90u, 311u}) {
        std::swap(map.cornerCoords[3 * t], map.cornerCoords[3 * t + 1]);
    }
    EXPECT_EQ(measure(s, map).foldOvers, 3u);
    // A vertex moved onto the opposite side: what remains of the triangle is narrower than a float of 24 mm can tell.
    const Vec3i t = s.graph.triangles[7];
    const Vec3f onto = (s.graph.points[std::size_t(t.y)] + s.graph.points[std::size_t(t.z)]) * 0.5f;
    s.graph.points[std::size_t(t.x)] = onto + (s.graph.points[std::size_t(t.x)] - onto) * 1e-6f;
    EXPECT_EQ(measure(s, map).foldOvers, 2u);
}

TEST(SynthesisQuality, CountsSeamsReuseAndErrorOfAKnownCut) {
    const int n = 24, cut = 11, shift = 8;
    const Synthesis s = flatTile(n, cut, shift);
    const SynthesisQuality q = measure(s, exemplarMap(s));
    // Links across x = cut + 1/2, and their error, by going through all pairs of triangle corners.
    std::size_t links = 0, seams = 0;
    double seamSquare = 0;
    std::vector<double> around(s.graph.size(), 0.0);
    for (std::size_t v = 0; v < s.graph.size(); ++v) {
        for (int k = s.graph.first[v]; k < s.graph.first[v + 1]; ++k) {
            const std::size_t u = std::size_t(s.graph.neighbour[std::size_t(k)]);
            const Vec3f a = s.graph.points[v], b = s.graph.points[u];
            const float offA = a.x > cut + 0.5f ? float(shift) : 0.0f, offB = b.x > cut + 0.5f ? float(shift) : 0.0f;
            const double d = double(squaredDistance(s.exemplar.stack[0].sample(b.x + offB, b.y),
                                                    s.exemplar.stack[0].sample(b.x + offA, b.y)));
            around[v] += d / (s.graph.first[v + 1] - s.graph.first[v] + 1);
            if (u > v) {
                ++links;
                seams += offA != offB;
                seamSquare += offA != offB ? d : 0.0;
            }
        }
    }
    double sum = 0;
    for (double a : around) {
        sum += a;
    }
    EXPECT_NEAR(q.seamRate, double(seams) / double(links), 1e-9);
    EXPECT_NEAR(q.seamError, std::sqrt(seamSquare / double(seams)), 1e-3 * q.seamError);
    EXPECT_NEAR(q.neighbourhoodError, std::sqrt(sum / double(s.graph.size())), 0.02 * q.neighbourhoodError);
    EXPECT_EQ(q.patches, 2u);
    // Texels of `shift` columns are shown twice, as many not at all.
    EXPECT_NEAR(q.reuseMax, 2, 0.05);
    EXPECT_NEAR(q.reuseEntropy, (std::log(double(n * n)) - 2.0 * shift / n * std::log(2.0)) / std::log(double(n * n)),
                0.008); // the cut runs through the middle of texels
}

TEST(SynthesisQuality, KolmogorovSmirnovIsTheLargestGapOfTheDistributions) {
    CounterRng rng(4, 4);
    std::vector<std::pair<float, double>> a, b;
    for (int i = 0; i < 60; ++i) {
        // Few values, so that there are ties.
        a.push_back({std::floor(8 * rng.uniform()), 0.1 + double(rng.uniform())});
        b.push_back({std::floor(8 * rng.uniform() * rng.uniform()), 0.1 + double(rng.uniform())});
    }
    const auto share = [](const auto& v, float upTo) {
        double below = 0, all = 0;
        for (const auto& [value, weight] : v) {
            below += value <= upTo ? weight : 0.0;
            all += weight;
        }
        return below / all;
    };
    double expected = 0;
    for (int at = -1; at < 9; ++at) {
        expected = std::max(expected, std::abs(share(a, float(at)) - share(b, float(at))));
    }
    EXPECT_NEAR(kolmogorovSmirnov(a, b), expected, 1e-12);
    EXPECT_NEAR(kolmogorovSmirnov(a, a), 0, 1e-12);
}
