// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/synthesize.h"

#include "stfLib/base/parallel.h"
#include "stfLib/synthesis/coherence_passes.h"
#include "stfLib/synthesis/quality.h"
#include "tests/unit/synthesis/synthesis_fixture.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

TEST(Synthesize, APlaneOfATileIsOnePatch) {
    // 48 x 48 texels of 0.5 mm on 24 x 24 mm: nothing asks for a seam.
    const BaseVolume v = waves(48);
    const Synthesis s = synthesized(refinedOf(rectangle(24, 24, 48, 48)), v);
    const SynthesisQuality q = measure(s, exemplarMap(s));
    EXPECT_LT(q.seamRate, 0.03);
    EXPECT_LT(q.neighbourhoodError, 0.3 * q.exemplarError);
    EXPECT_LT(q.stretch, 0.05);
    EXPECT_EQ(q.foldOvers, 0u);
}

TEST(Synthesize, APlaneOfManyTilesDoesNotRepeatWhatIsAlikeElsewhere) {
    // 4 x 4 tiles of 20 mm; tiled plainly, every place would be shown again a tile further.
    const int n = 160, tile = 40;
    BaseVolume v = waves(tile);
    for (Rgb& a : v.albedo) {
        a = Rgb(0.97f) + (a - Rgb(0.97f)) * 0.25f; // so little contrast that any place looks much like another
    }
    const RefinedSurface surface = refinedOf(rectangle(80, 80, n, n));
    const Synthesis s = synthesized(surface, v);
    ASSERT_LT(s.exemplar.ownError, 2.5);
    ASSERT_GT(s.exemplar.ownError, 0.1);
    std::size_t repeated = 0, pairs = 0;
    for (int y = 0; y <= n; ++y) {
        for (int x = 0; x + tile <= n; ++x) {
            // The field may point anywhere, so both ways along it are asked.
            const std::size_t a = std::size_t(s.graph.vertexOfPoint[std::size_t(y * (n + 1) + x)]);
            for (const auto& [dx, dy] : {std::pair(tile, 0), std::pair(0, tile)}) {
                if (x + dx <= n && y + dy <= n) {
                    const std::size_t b = std::size_t(s.graph.vertexOfPoint[std::size_t((y + dy) * (n + 1) + x + dx)]);
                    const Vec3f step = s.graph.points[b] - s.graph.points[a];
                    const Vec3f along = s.directions[a];
                    const Vec2f moved(dot(step, along), dot(step, cross(s.graph.normals[a], along)));
                    // Continued: coordinates differ by the step, whatever its direction.
                    const Vec2f d = nearestImage(s.coords.coord[b] - s.coords.coord[a] - moved, s.exemplar.tileMm());
                    repeated += std::hypot(d.x, d.y) < 1.0f;
                    ++pairs;
                }
            }
        }
    }
    EXPECT_LT(double(repeated), 0.4 * double(pairs));
    EXPECT_LT(measure(s, exemplarMap(s)).seamRate, 0.06);
}

TEST(Synthesize, ATorusMeetsTheTargets) {
    const BaseVolume v = waves(48);
    const RefinedSurface surface = sampledTorus(0.5);
    const Synthesis s = synthesized(surface, v);
    const SynthesisQuality q = measure(s, exemplarMap(s));
    EXPECT_NEAR(q.texelsPerSample, 1, 0.4);
    EXPECT_LT(q.seamRate, 0.05);
    EXPECT_LT(q.neighbourhoodError, 1.5 * q.exemplarError);
    EXPECT_LT(q.reuseMax, 3);
    EXPECT_GT(q.reuseEntropy, 0.98);
    EXPECT_LT(q.ks, 0.05);
    EXPECT_LT(std::abs(q.deltaR), 0.02);
    EXPECT_EQ(q.foldOvers, 0u);
    EXPECT_EQ(q.indexSum, 0);
    EXPECT_LT(q.stretch, 0.2);
}

TEST(Synthesize, GivesCoordinatesThatAreContinuousWithinTrianglesAndAcrossUnbrokenLinks) {
    const BaseVolume v = waves(32);
    const RefinedSurface surface = sampledTorus(1.0);
    const Synthesis s = synthesized(surface, v, 3);
    const ExemplarMap map = exemplarMap(s);
    ASSERT_EQ(map.cornerCoords.size(), 3 * surface.triangles.size());
    std::size_t unbroken = 0;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        bool whole = true;
        for (int c = 0; c < 3; ++c) {
            const std::size_t i = 3 * t + std::size_t(c);
            const Vec2f d = map.cornerCoords[3 * t + std::size_t((c + 1) % 3)] - map.cornerCoords[i];
            const float l = length(surface.points[std::size_t(surface.triangles[t][c])] -
                                   surface.points[std::size_t(surface.triangles[t][(c + 1) % 3])]);
            EXPECT_LT(std::hypot(d.x, d.y), 2.2 * double(l) + 1.0);
            // Gradients are tangent and of the scale of the sample.
            const Vec3f n = surface.normals[std::size_t(surface.triangles[t][c])];
            EXPECT_NEAR(dot(map.gradientX[i], n), 0, 1e-3);
            EXPECT_GT(length(map.gradientX[i]), 0.3f);
            EXPECT_LT(length(map.gradientX[i]), 3.0f);
            const int a = s.graph.triangles[t][c], b = s.graph.triangles[t][(c + 1) % 3];
            for (int k = s.graph.first[std::size_t(a)]; k < s.graph.first[std::size_t(a) + 1]; ++k) {
                whole = whole && !(s.graph.neighbour[std::size_t(k)] == b && s.coords.broken[std::size_t(k)]);
            }
        }
        if (whole) {
            ++unbroken;
            for (int c = 0; c < 3; ++c) {
                // What the vertex shows, whichever triangle asks.
                const Vec2f shown = s.coords.coord[std::size_t(s.graph.triangles[t][c])];
                const Vec2f d = nearestImage(map.cornerCoords[3 * t + std::size_t(c)] - shown, map.tileMm);
                EXPECT_LT(std::hypot(d.x, d.y), 1e-3);
            }
        }
    }
    EXPECT_GT(unbroken, surface.triangles.size() * 8 / 10);
}

TEST(Synthesize, DoesNotDependOnThreadsButOnTheSeed) {
    const BaseVolume v = waves(32);
    const RefinedSurface surface = sampledTorus(1.0);
    setThreadCount(1);
    const Synthesis one = synthesized(surface, v);
    setThreadCount(4);
    const Synthesis four = synthesized(surface, v);
    setThreadCount(0);
    EXPECT_EQ(one.coords.coord, four.coords.coord);
    EXPECT_EQ(one.coords.broken, four.coords.broken);
    EXPECT_NE(one.coords.coord, synthesized(surface, v, 1).coords.coord);
}

TEST(Synthesize, FollowsAnAuthoredTangentField) {
    const BaseVolume v = waves(32);
    const RefinedSurface surface = refinedOf(rectangle(20, 20, 40, 40));
    SynthesisOptions options;
    const Vec3f wanted = normalize(Vec3f(1, 1, 0));
    options.orientation.assign(surface.points.size(), wanted);
    Progress progress;
    const Synthesis s = synthesize(surface, v, 1, options, progress);
    for (const Vec3f& g : exemplarMap(s).gradientX) {
        EXPECT_GT(dot(normalize(g), wanted), 0.97f);
    }
}

// An authored field from the control mesh to the exemplar's coordinates: around the axis of a ball, nothing at its
// poles.
TEST(Synthesize, FollowsAnAuthoredFieldOnACurvedSurface) {
    ControlMesh ball = sphere(10, 12);
    for (const Vec3f& p : ball.points) {
        ball.orientation.push_back(std::abs(p.z) < 9 ? Vec3f(-p.y, p.x, 0) : Vec3f());
    }
    const RefinedSurface surface = sampleSurface(refinedOf(ball), 0.5, 1, 1000000, {});
    SynthesisOptions options;
    options.orientation = surface.orientation;
    Progress progress;
    const Synthesis s = synthesize(surface, waves(32), 1, options, progress);
    const auto degrees = [](const Vec3d& a, const Vec3d& b) {
        return std::acos(std::clamp(dot(normalize(a), normalize(b)), -1.0, 1.0)) * 180 / pi;
    };
    std::vector<double> field, axis;
    for (std::size_t v = 0; v < s.graph.size(); ++v) {
        const Vec3d p(s.graph.points[v]);
        if (std::abs(p.z) < 8) {
            field.push_back(degrees(Vec3d(s.directions[v]), {-p.y, p.x, 0}));
        }
    }
    const ExemplarMap map = exemplarMap(s);
    for (std::size_t i = 0; i < map.gradientX.size(); ++i) {
        const Vec3d p(surface.points[std::size_t(surface.triangles[i / 3][int(i % 3)])]);
        if (std::abs(p.z) < 8) {
            axis.push_back(degrees(Vec3d(map.gradientX[i]), {-p.y, p.x, 0}));
        }
    }
    std::sort(field.begin(), field.end());
    std::sort(axis.begin(), axis.end());
    RecordProperty("field_largest", std::to_string(field.back()));
    RecordProperty("axis_median", std::to_string(axis[axis.size() / 2]));
    RecordProperty("axis_95", std::to_string(axis[axis.size() * 95 / 100]));
    EXPECT_LT(field.back(), 4);
    EXPECT_LT(axis[axis.size() / 2], 6);
    EXPECT_LT(axis[axis.size() * 95 / 100], 25);
    // Without a wish at the poles the field still turns around them: index 1 each.
    int sum = 0;
    for (const Singularity& q : s.singularities) {
        sum += q.index;
        EXPECT_GT(std::abs(s.graph.points[std::size_t(s.graph.triangles[std::size_t(q.triangle)].x)].z), 8);
    }
    EXPECT_EQ(sum, 2);
}

TEST(Synthesize, StopsWhenCancelled) {
    Progress progress;
    progress.cancel();
    EXPECT_THROW(synthesize(refinedOf(rectangle(8, 8, 16, 16)), waves(16), 1, {}, progress), Cancelled);
}

TEST(Synthesize, RefusesWhatItCannotUse) {
    Progress progress;
    const RefinedSurface plane = refinedOf(rectangle(1, 1, 2, 2));
    EXPECT_THROW(synthesize(plane, waves(8), 0, {}, progress), Error);
    EXPECT_THROW(synthesize(RefinedSurface(), waves(8), 1, {}, progress), Error);
    SynthesisOptions options;
    options.orientation.resize(2);
    EXPECT_THROW(synthesize(plane, waves(8), 1, options, progress), Error);
}

TEST(Synthesize, TakesTinyTilesOpenMeshesAndLoneParts) {
    // A tile of one column, and one narrower than a patch.
    for (int n : {1, 5}) {
        const Synthesis s = synthesized(refinedOf(rectangle(8, 8, 20, 20)), waves(n));
        EXPECT_EQ(measure(s, exemplarMap(s)).foldOvers, 0u);
    }
    ControlMesh two = rectangle(3, 3, 6, 6);
    const int base = int(two.points.size());
    two.points.insert(two.points.end(), {{50, 0, 0}, {51, 0, 0}, {50, 1, 0}});
    addFace(two, {base, base + 1, base + 2});
    two.uvs.clear();
    two.uvIndices.clear();
    const Synthesis s = synthesized(refinedOf(two), waves(16));
    for (const Vec2f& c : s.coords.coord) {
        EXPECT_TRUE(std::isfinite(c.x) && std::isfinite(c.y));
    }
}

TEST(CoherencePasses, LowerTheErrorOfABadCut) {
    const BaseVolume v = waves(32);
    const RefinedSurface surface = sampledTorus(1.0);
    Synthesis s = synthesized(surface, v);
    // Every vertex takes the first chart that holds it, wherever that leaves the seams.
    const std::vector<Vec2f> offset = [&] {
        std::vector<Vec2f> of(s.cover.charts.size());
        for (std::size_t i = 0; i < s.graph.size(); ++i) {
            of[std::size_t(s.cover.chart[std::size_t(s.labels.entry[i])])] = s.labels.offset[i];
        }
        return of;
    }();
    for (std::size_t i = 0; i < s.graph.size(); ++i) {
        s.labels.entry[i] = s.cover.first[i];
        s.labels.offset[i] = offset[std::size_t(s.cover.chart[std::size_t(s.cover.first[i])])];
    }
    const auto error = [&] {
        Progress progress;
        s.coords = healBreaks(s.graph, s.steps, s.cover, s.exemplar, s.labels, 1, progress);
        return measure(s, exemplarMap(s)).neighbourhoodError;
    };
    const double before = error();
    Progress progress;
    EXPECT_GT(correctByCoherence(s.graph, s.steps, s.cover, s.exemplar, {}, s.labels, progress), 0u);
    EXPECT_LT(error(), before);
}
