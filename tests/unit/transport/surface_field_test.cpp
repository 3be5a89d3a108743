// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/surface_field.h"

#include "stfLib/base/random.h"
#include "tests/unit/transport/reliefs.h"

#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

const Vec3i kSize(6, 4, 5);
const Vec3d kVoxelMm(0.5, 0.8, 0.3);

SurfaceField field(const Relief& r, const Vec3i& size = kSize) {
    BaseVolume v = homogeneous(size, kVoxelMm, Rgb(1.0f), Rgb(0.0f));
    r.carve(v);
    return SurfaceField(size, kVoxelMm, v.surface);
}

// Any distances, smooth enough to be a surface.
SurfaceField wild(std::uint64_t seed) {
    CounterRng rng(seed, 0);
    std::vector<float> d(120);
    for (float& x : d) {
        x = rng.uniform() - 0.5f;
    }
    return SurfaceField(kSize, kVoxelMm, d);
}

TEST(SurfaceField, EmptyWithoutAVoxelOutside) {
    EXPECT_TRUE(SurfaceField().empty());
    EXPECT_TRUE(SurfaceField(kSize, kVoxelMm, {}).empty());
    EXPECT_TRUE(SurfaceField(kSize, kVoxelMm, std::vector<float>(120, -1.0f)).empty());
    EXPECT_FALSE(SurfaceField(kSize, kVoxelMm, std::vector<float>(120, 1.0f)).empty());
}

TEST(SurfaceField, TrilinearPeriodicAndConstantBeyondTheLastLayers) {
    const SurfaceField f = wild(1);
    CounterRng rng(2, 0);
    for (int i = 0; i < 500; ++i) {
        const Vec3f p{6 * rng.uniform(), 4 * rng.uniform(), 5 * rng.uniform()};
        EXPECT_NEAR(f.value(p), f.value(p + Vec3f(6, -4, 0)), 2e-6f);
        EXPECT_EQ(f.value({p.x, p.y, 0}), f.value({p.x, p.y, 0.5f}));
        EXPECT_EQ(f.value({p.x, p.y, 5}), f.value({p.x, p.y, 4.5f}));
        // Continuous across faces and middles.
        const Vec3f q{std::round(2 * p.x) / 2, p.y, p.z}, e{1e-4f, 0, 0};
        EXPECT_NEAR(f.value(q - e), f.value(q + e), 1e-3f);
    }
}

// The distance to a ball has no creases; those of its interpolant are smoothed, which costs less than they do.
TEST(SurfaceField, SmoothNormalIsThatOfABallAndHasNoCreases) {
    const Vec3i size(16, 16, 16);
    const Vec3d mm(0.1, 0.1, 0.1);
    std::vector<float> distance;
    for (int z = 0; z < 16; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                distance.push_back(float(length(Vec3d(x - 7.5, y - 7.5, z - 7.5)) * 0.1 - 0.5));
            }
        }
    }
    const SurfaceField f(size, mm, distance);
    CounterRng rng(4, 0);
    double faceted = 0, smooth = 0;
    for (int i = 0; i < 400; ++i) {
        const float cosine = 2 * rng.uniform() - 1, phi = 6.2831853f * rng.uniform();
        const float sine = std::sqrt(1 - cosine * cosine);
        const Vec3f n{sine * std::cos(phi), sine * std::sin(phi), cosine}, p = Vec3f(8.0f) + n * 5;
        faceted = std::max(faceted, double(length(f.normal(p) - n)));
        smooth = std::max(smooth, double(length(f.smoothNormal(p) - n)));
        // Across a middle, where the interpolant bends.
        const Vec3f crease{std::round(p.x - 0.5f) + 0.5f, p.y, p.z}, e{1e-4f, 0, 0};
        EXPECT_LT(length(f.smoothNormal(crease - e) - f.smoothNormal(crease + e)), 1e-3f);
    }
    EXPECT_LT(smooth, 0.03);
    EXPECT_LT(smooth, 0.5 * faceted);
}

TEST(SurfaceField, ValuesOfAPolygonAreExact) {
    const Relief r = waves(6, 2.4, 1.3);
    const SurfaceField f = field(r);
    CounterRng rng(3, 0);
    for (int i = 0; i < 500; ++i) {
        const Vec3f p{6 * rng.uniform(), 4 * rng.uniform(), 0.5f + 4 * rng.uniform()};
        EXPECT_NEAR(double(f.value(p)), (r.at(double(p.x)) - double(p.z)) * kVoxelMm.z, 2e-6);
        EXPECT_EQ(f.inside(p), f.value(p) < 0);
    }
}

TEST(SurfaceField, NormalsAreUnitAndPointOut) {
    // A side that falls one voxel per column, in mm: (0.3 / 0.5, -1); z inward.
    const SurfaceField f = field(groove(6, 0.5, 3.5));
    const Vec3f left = f.normal({1.7f, 1.2f, 2}), right = f.normal({4.7f, 1.2f, 2});
    const double slope = 0.3 / 0.5, l = std::sqrt(1 + slope * slope);
    EXPECT_NEAR(double(left.x), slope / l, 1e-4);
    EXPECT_NEAR(double(left.z), -1 / l, 1e-4);
    EXPECT_NEAR(double(right.x), -slope / l, 1e-4);
    EXPECT_NEAR(double(left.y), 0, 1e-4);
    const SurfaceField w = wild(4);
    CounterRng rng(5, 0);
    for (int i = 0; i < 500; ++i) {
        const Vec3f p{6 * rng.uniform(), 4 * rng.uniform(), 0.6f + 3.8f * rng.uniform()}, n = w.normal(p);
        EXPECT_NEAR(length(n), 1, 1e-5f);
        const float h = 1e-3f; // mm
        const Vec3f step{n.x * h / 0.5f, n.y * h / 0.8f, n.z * h / 0.3f};
        EXPECT_GT(w.value(p + step), w.value(p - step) - 1e-5f);
    }
}

TEST(SurfaceField, KindsOfVoxelsAreWhatTheyHold) {
    for (std::uint64_t seed : {1, 2, 3}) {
        const SurfaceField f = wild(seed);
        CounterRng rng(seed, 9);
        for (std::size_t i = 0; i < 120; ++i) {
            if (f.crossedBySurface(i)) {
                continue;
            }
            for (int k = 0; k < 50; ++k) {
                const Vec3f p{float(i % 6) + rng.uniform(), float(i / 6 % 4) + rng.uniform(),
                              float(i / 24) + rng.uniform()};
                ASSERT_EQ(f.inside(p), f.insideVoxel(i));
            }
        }
    }
    const SurfaceField f = field(waves(6, 2.4, 0.1));
    EXPECT_FALSE(f.crossedBySurface(0));
    EXPECT_FALSE(f.insideVoxel(0));
    EXPECT_TRUE(f.crossedBySurface(2 * 24));
    EXPECT_FALSE(f.crossedBySurface(4 * 24));
    EXPECT_TRUE(f.insideVoxel(4 * 24));
}

// Along lines within one voxel: the first change of sign, as fine steps find it.
TEST(SurfaceField, CrossingsAreWhereTheSignChanges) {
    int crossings = 0, missed = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const SurfaceField f = wild(seed);
        CounterRng rng(seed, 7);
        for (int i = 0; i < 1500; ++i) {
            const Vec3f corner{std::floor(6 * rng.uniform()), std::floor(4 * rng.uniform()),
                               std::floor(5 * rng.uniform())};
            const auto inVoxel = [&] { return corner + Vec3f(rng.uniform(), rng.uniform(), rng.uniform()); };
            const Vec3f a = inVoxel(), d = inVoxel() - a;
            const bool in = f.inside(a);
            const float t = f.crossing(Vec3i(corner), a, d, 0, 1, in);
            float expected = std::numeric_limits<float>::infinity();
            for (int k = 1; k <= 400 && expected > 1; ++k) {
                const float at = float(k) / 400;
                expected = f.inside(a + d * at) != in ? at : expected;
            }
            if (expected > 1) {
                ASSERT_TRUE(t > 1 || std::abs(f.value(a + d * t)) < 1e-4f);
                continue;
            }
            ++crossings;
            if (t > 1 || std::abs(t - expected) > 0.004f) {
                ++missed; // a double root within a third of a piece
                continue;
            }
            ASSERT_NEAR(f.value(a + d * t), 0, 1e-5f);
        }
    }
    EXPECT_GT(crossings, 1000);
    EXPECT_LT(missed, crossings / 50);
}

TEST(SurfaceField, AWalkerOnItsWayBackPassesNothing) {
    // The surface lies on a face between voxels, where rounding decides; a reflected walker starts a hair beyond.
    const SurfaceField f = field(Relief{std::vector<double>(6, 2.0)});
    constexpr float kInf = std::numeric_limits<float>::infinity();
    const Vec3f below{0.5f, 0.5f, 2 + 1e-6f}, above{0.5f, 0.5f, 2 - 1e-6f};
    for (float dz : {1.0f, 1e-2f, 1e-4f}) {
        EXPECT_EQ(f.crossing({0, 0, 2}, below, {1, 0, -dz}, 0, 1e-6f, false), kInf) << "up, back to the outside";
        EXPECT_EQ(f.crossing({0, 0, 1}, above, {1, 0, dz}, 0, 1e-6f, true), kInf) << "down, back to the inside";
        EXPECT_EQ(f.crossing({0, 0, 1}, below - Vec3f(0, 0, 2e-6f), {1, 0, -dz}, 0, 0.4f, false), kInf);
    }
    // On its way deeper it passes.
    EXPECT_LT(f.crossing({0, 0, 2}, below, {0, 0, 1}, 0, 0.4f, false), 1e-3f);
    EXPECT_LT(f.crossing({0, 0, 1}, above, {0, 0, -1}, 0, 0.4f, true), 1e-3f);
}

TEST(SurfaceField, PiecesCoverAStretchAndAlternate) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        const SurfaceField f = wild(seed);
        CounterRng rng(seed, 8);
        for (int i = 0; i < 1000; ++i) {
            const Vec3f corner{std::floor(6 * rng.uniform()), std::floor(4 * rng.uniform()),
                               std::floor(5 * rng.uniform())};
            const Vec3f a = corner + Vec3f(rng.uniform(), rng.uniform(), rng.uniform());
            const Vec3f d = corner + Vec3f(rng.uniform(), rng.uniform(), rng.uniform()) - a;
            float end = 0;
            int last = -1;
            f.pieces(Vec3i(corner), a, d, 0, 1, [&](float t0, float t1, bool in) {
                ASSERT_EQ(t0, end);
                ASSERT_GT(t1, t0);
                ASSERT_NE(int(in), last);
                end = t1;
                last = int(in);
                if (t1 - t0 > 0.05f) {
                    ASSERT_EQ(f.inside(a + d * (0.5f * (t0 + t1))), in);
                }
            });
            ASSERT_EQ(end, 1);
        }
    }
}

TEST(SurfaceField, FillIsTheShareInside) {
    // Level: exact. A wall along y between columns 2 and 3: half of each of the two.
    for (double depth : {1.3, 2.0, 2.81}) {
        const std::vector<float> fill = field(Relief{std::vector<double>(6, depth)}).fill();
        for (int z = 0; z < 5; ++z) {
            const double expected = std::min(1.0, std::max(0.0, z + 1 - depth));
            EXPECT_NEAR(double(fill[std::size_t(z) * 24 + 5]), expected, 2e-4);
        }
    }
    std::vector<float> d(120);
    for (std::size_t i = 0; i < 120; ++i) {
        d[i] = i % 6 < 3 ? 0.75f : -0.25f; // the wall at 3/4 from middle to middle, at x = 3.25
    }
    const std::vector<float> fill = SurfaceField(kSize, kVoxelMm, d).fill();
    EXPECT_EQ(fill[1], 0);
    EXPECT_EQ(fill[2], 0);
    EXPECT_NEAR(fill[3], 0.75f, 0.004f);
    EXPECT_EQ(fill[4], 1);
    EXPECT_NEAR(fill[5], 0.75f, 0.004f) << "the other wall, back through the tile's side at x = 5.75";
    // The sum over a column is the mean depth of the polygon there.
    const Relief r = waves(6, 2.4, 1.3);
    const std::vector<float> columns = field(r).fill();
    for (std::size_t x = 0; x < 6; ++x) {
        double sum = 0, mean = 0;
        for (std::size_t z = 0; z < 5; ++z) {
            sum += double(columns[x + 24 * z]);
        }
        for (int k = 0; k < 1000; ++k) {
            mean += r.at(double(x) + (k + 0.5) / 1000) / 1000;
        }
        EXPECT_NEAR(sum, 5 - mean, 1e-3);
    }
}

} // namespace
