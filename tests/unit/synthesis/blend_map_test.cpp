// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/blend_map.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "tests/unit/surface/test_meshes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

using namespace stf;
using namespace stf::test;

namespace {

const Vec2d kTile{2, 2};
constexpr double kMmPerUnit = 4;

RefinedSurface sphere(int level = 5) {
    ControlMesh mesh = cube(ControlMesh::Scheme::CatmullClark);
    sanitize(mesh);
    RefineOptions options;
    options.level = level;
    return refine(mesh, options, {});
}

BlendMap blended(const RefinedSurface& s, std::uint64_t seed = 0) {
    Progress progress;
    return blendMap(s, kTile, kMmPerUnit, seed, progress);
}

// A smooth periodic function over the tile, blended as deviations are: what a point looks like.
double look(const TriangleBlend& t, const Vec2f& coord) {
    const Vec2f tile(float(kTile.x), float(kTile.y));
    const PlacesAt p = placesAt(t, coord, tile);
    double sum = 0, squares = 0;
    const Vec2f at[3] = {coord, p.other[0], p.other[1]};
    for (std::size_t k = 0; k < 3; ++k) {
        const double w = double(p.weight[k]);
        sum += w * std::sin(3.14159265 * double(at[k].x)) * std::cos(3.14159265 * double(at[k].y));
        squares += w * w;
    }
    return sum / std::sqrt(squares);
}

TEST(BlendMap, WeightsArePositiveAndAddUpToOne) {
    const RefinedSurface s = sphere();
    const BlendMap map = blended(s);
    ASSERT_EQ(map.triangles.size(), s.triangles.size());
    std::size_t several = 0;
    CounterRng rng(1, 1);
    for (std::size_t t = 0; t < map.triangles.size(); ++t) {
        const float a = std::sqrt(rng.uniform()), b = rng.uniform();
        const Vec2f* c = &map.first.cornerCoords[3 * t];
        const Vec2f at = c[0] * (1 - a) + c[1] * (a * (1 - b)) + c[2] * (a * b);
        const PlacesAt p = placesAt(map.triangles[t], at + Vec2f(4, -6), Vec2f(2, 2)); // whole tiles away
        EXPECT_NEAR(p.weight[0] + p.weight[1] + p.weight[2], 1, 1e-5);
        for (float w : p.weight) {
            EXPECT_GE(w, 0);
        }
        several += p.weight[1] > 0.05f;
    }
    EXPECT_GT(double(several), 0.7 * double(map.triangles.size()));
}

TEST(BlendMap, WhatIsSeenDoesNotJumpBetweenTriangles) {
    const RefinedSurface s = sphere(6);
    const BlendMap map = blended(s);
    // Both triangles of an edge, at points along it.
    std::map<std::pair<int, int>, std::pair<std::size_t, int>> open;
    double worst = 0, sum = 0, step = 0;
    int count = 0, jumps = 0;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        for (int c = 0; c < 3; ++c) {
            const int a = s.triangles[t][c], b = s.triangles[t][(c + 1) % 3];
            const auto found = open.find({b, a});
            if (found == open.end()) {
                open[{a, b}] = {t, c};
                continue;
            }
            const auto [u, d] = found->second;
            const Vec2f* here = &map.first.cornerCoords[3 * t];
            const Vec2f* there = &map.first.cornerCoords[3 * u];
            for (float f : {0.0f, 0.3f, 0.7f}) {
                const double mine = look(map.triangles[t], here[c] * (1 - f) + here[(c + 1) % 3] * f);
                const double other = look(map.triangles[u], there[d] * f + there[(d + 1) % 3] * (1 - f));
                worst = std::max(worst, std::abs(mine - other));
                jumps += std::abs(mine - other) > 0.25;
                sum += (mine - other) * (mine - other);
                ++count;
            }
            const double change = look(map.triangles[t], here[c]) - look(map.triangles[t], here[(c + 1) % 3]);
            step += change * change;
        }
    }
    // The rms jump is small against what the function changes along an edge (3 points each).
    EXPECT_LT(std::sqrt(sum / count), 0.25 * std::sqrt(3 * step / count));
    EXPECT_LT(jumps, 0.005 * count) << worst;
}

TEST(BlendMap, IsTheSameForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
    const RefinedSurface s = sphere();
    setThreadCount(1);
    const BlendMap one = blended(s);
    setThreadCount(0);
    const BlendMap all = blended(s);
    EXPECT_EQ(one.first.cornerCoords, all.first.cornerCoords);
    for (std::size_t t = 0; t < one.triangles.size(); ++t) {
        ASSERT_EQ(one.triangles[t].weight, all.triangles[t].weight);
        ASSERT_EQ(one.triangles[t].other[0], all.triangles[t].other[0]);
    }
    EXPECT_NE(one.first.cornerCoords, blended(s, 1).first.cornerCoords);
}

TEST(BlendMap, KeepsTheScaleOfTheSample) {
    const RefinedSurface s = sphere();
    const BlendMap map = blended(s);
    double logs = 0;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
        const Vec3i& tri = s.triangles[t];
        const double area = length(cross(Vec3d(s.points[std::size_t(tri.y)] - s.points[std::size_t(tri.x)]),
                                         Vec3d(s.points[std::size_t(tri.z)] - s.points[std::size_t(tri.x)])));
        const Vec2f* c = &map.first.cornerCoords[3 * t];
        const double mapped = double((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[1].y - c[0].y) * (c[2].x - c[0].x));
        ASSERT_GT(mapped, 0) << t; // no folds
        logs += std::log(mapped / (area * kMmPerUnit * kMmPerUnit)) / double(s.triangles.size());
    }
    EXPECT_NEAR(logs, 0, 0.1);
}

} // namespace
