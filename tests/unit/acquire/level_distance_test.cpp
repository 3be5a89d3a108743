// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/level_distance.h"

#include "stfLib/base/random.h"
#include "stfLib/transport/surface_field.h"
#include "tests/unit/support/files.h"

#include <cmath>

using namespace stf;
using namespace stf::test;

namespace {

const double kRadius = 16; // voxels: 32 across

std::size_t at(const Vec3i& n, int x, int y, int z) {
    return std::size_t(x) + std::size_t(n.x) * (std::size_t(y) + std::size_t(n.y) * std::size_t(z));
}

// Level of a sphere: (0.5 - share of each voxel inside), as a scanner's partial volumes give it, from 5^3 points.
std::vector<float> coverage(const Vec3i& n, const Vec3d& h, const Vec3d& middle, double radius) {
    std::vector<float> level;
    for (int z = 0; z < n.z; ++z) {
        for (int y = 0; y < n.y; ++y) {
            for (int x = 0; x < n.x; ++x) {
                int inside = 0;
                for (int k = 0; k < 125; ++k) {
                    const Vec3d p = Vec3d(x + (k % 5 + 0.5) / 5, y + (k / 5 % 5 + 0.5) / 5, z + (k / 25 + 0.5) / 5) * h;
                    inside += length(p - middle) < radius ? 1 : 0;
                }
                level.push_back(float(0.5 - inside / 125.0));
            }
        }
    }
    return level;
}

// Angles in degrees: of the distance's gradient at the voxels that the surface may cut (by differences over two
// voxels), and as the renderer sees it, between them. There a trilinear interpolant of the exact distance is 2.4
// degrees off.
struct Errors {
    double worstAngle = 0, meanAngle = 0, worstBetween = 0, worstDistance = 0, meanRadius = 0;
};

void addVoxels(const Vec3i& n, const Vec3d& h, const std::vector<float>& d, const Vec3d& middle, Errors& e) {
    int count = 0;
    for (int z = 1; z + 1 < n.z; ++z) {
        for (int y = 1; y + 1 < n.y; ++y) {
            for (int x = 1; x + 1 < n.x; ++x) {
                if (std::abs(double(d[at(n, x, y, z)])) > 0.5 * length(h)) {
                    continue;
                }
                const auto slope = [&](int i, int j, int k) {
                    return double(d[at(n, x + i, y + j, z + k)]) - double(d[at(n, x - i, y - j, z - k)]);
                };
                const Vec3d g(slope(1, 0, 0) / h.x, slope(0, 1, 0) / h.y, slope(0, 0, 1) / h.z);
                const Vec3d exact = normalize(Vec3d(x + 0.5, y + 0.5, z + 0.5) * h - middle);
                const double angle = std::acos(std::min(1.0, dot(normalize(g), exact))) * 180 / M_PI;
                e.worstAngle = std::max(e.worstAngle, angle);
                e.meanAngle += angle;
                ++count;
            }
        }
    }
    e.meanAngle /= count;
}

// The surface along rays from the middle, as SurfaceField has it.
Errors errorsOf(const Vec3i& n, const Vec3d& h, const std::vector<float>& distance, const Vec3d& middle,
                double radius) {
    const SurfaceField field(n, h, distance);
    Errors e;
    addVoxels(n, h, distance, middle, e);
    CounterRng rng(4, 0);
    const int rays = 4000;
    for (int i = 0; i < rays; ++i) {
        const double z = 2 * double(rng.uniform()) - 1, phi = 2 * M_PI * double(rng.uniform()),
                     s = std::sqrt(1 - z * z);
        const Vec3d d(s * std::cos(phi), s * std::sin(phi), z);
        double lo = 0.8 * radius, hi = 1.2 * radius;
        for (int k = 0; k < 30; ++k) {
            const double r = (lo + hi) / 2;
            const Vec3d p = middle + d * r;
            (field.value(Vec3f(Vec3d(p.x / h.x, p.y / h.y, p.z / h.z))) < 0 ? lo : hi) = r;
        }
        const Vec3d p = middle + d * lo;
        const Vec3d normal(field.normal(Vec3f(Vec3d(p.x / h.x, p.y / h.y, p.z / h.z))));
        const double angle = std::acos(std::min(1.0, dot(normal, d))) * 180 / M_PI;
        e.worstBetween = std::max(e.worstBetween, angle);
        e.worstDistance = std::max(e.worstDistance, std::abs(lo - radius));
        e.meanRadius += lo / rays;
    }
    return e;
}

Errors sphere(double smooth, double noise, const Vec3d& h = Vec3d(1.0)) {
    const double radius = kRadius * minComponent(h);
    const Vec3i n(int(40 / h.x), int(40 / h.y), int(40 / h.z));
    const Vec3d middle = Vec3d(n) * h * 0.5 + Vec3d(0.13, -0.21, 0.37) * h;
    std::vector<float> level = coverage(n, h, middle, radius);
    CounterRng rng(1, 0);
    for (float& v : level) {
        v += float(noise) * (rng.uniform() + rng.uniform() + rng.uniform() - 1.5f) * 2; // standard deviation `noise`
    }
    Progress progress;
    auto d = signedDistance(n, h, smoothLevel(n, level, smooth), progress);
    moveToShare(n, h, insideShareOfLevel(n, h, level), d);
    const Errors e = errorsOf(n, h, d, middle, radius);
    const double volume = insideShare(n, h, d) * n.x * n.y * n.z * h.x * h.y * h.z;
    const double exact = 4 * M_PI / 3 * radius * radius * radius;
    std::printf(
        "             smooth %.1f noise %.2f: normals %.2f degrees at most, %.2f on average, %.2f between voxels; "
        "surface %.3f off at most, radius %+.4f; volume %+.2f %%\n",
        smooth, noise, e.worstAngle, e.meanAngle, e.worstBetween, e.worstDistance, e.meanRadius - radius,
        100 * (volume / exact - 1));
    EXPECT_NEAR(volume, exact, 0.005 * exact);
    return e;
}

TEST(LevelDistance, NormalsOfASphereOf32Voxels) {
    const Errors e = sphere(1.3, 0);
    EXPECT_LT(e.worstAngle, 2);
    EXPECT_LT(e.meanAngle, 0.6);
    EXPECT_LT(e.worstBetween, 4);
    EXPECT_LT(e.worstDistance, 0.1);
    EXPECT_NEAR(e.meanRadius, kRadius, 0.03);
}

TEST(LevelDistance, NoiseIsTakenOff) {
    const Errors rough = sphere(0.8, 0.05), smooth = sphere(2, 0.05);
    EXPECT_GT(rough.worstAngle, 4);
    EXPECT_LT(smooth.worstAngle, 2);
    EXPECT_NEAR(smooth.meanRadius, kRadius, 0.03);
}

TEST(LevelDistance, AnisotropicVoxels) {
    const Errors e = sphere(1.3, 0, {1, 1, 1.6});
    EXPECT_LT(e.worstAngle, 2.5);
    EXPECT_NEAR(e.meanRadius, kRadius, 0.05);
}

// Where the level is the distance itself, it is found again everywhere, over the wrap as well.
TEST(LevelDistance, OfADistance) {
    const Vec3i n(48, 40, 30);
    const Vec3d h(0.5, 0.5, 0.4), middle(1.0, 2.0, 6.1); // sticks out of the sides
    const Vec3d extent = Vec3d(n) * h;
    const auto exact = [&](int x, int y, int z) {
        Vec3d d = Vec3d(x + 0.5, y + 0.5, z + 0.5) * h - middle;
        d.x -= extent.x * std::round(d.x / extent.x);
        d.y -= extent.y * std::round(d.y / extent.y);
        return length(d) - 4;
    };
    std::vector<float> level(at(n, 0, 0, n.z));
    for (int z = 0; z < n.z; ++z) {
        for (int y = 0; y < n.y; ++y) {
            for (int x = 0; x < n.x; ++x) {
                const double d = exact(x, y, z);
                level[at(n, x, y, z)] = float(1000 * (d + 0.05 * d * d)); // rises with distance, by another law
            }
        }
    }
    Progress progress;
    const auto found = signedDistance(n, h, level, progress);
    double nearWorst = 0, worst = 0;
    for (int z = 0; z < n.z; ++z) {
        for (int y = 0; y < n.y; ++y) {
            for (int x = 0; x < n.x; ++x) {
                const double d = exact(x, y, z), e = std::abs(double(found[at(n, x, y, z)]) - d);
                // Half a tile away two images of the sphere meet in a ridge.
                (std::abs(d) < 0.5 ? nearWorst : worst) = std::max(std::abs(d) < 0.5 ? nearWorst : worst, e);
            }
        }
    }
    std::printf("             %.4f mm off beside the surface, %.4f mm elsewhere\n", nearWorst, worst);
    EXPECT_LT(nearWorst, 0.01);
    EXPECT_LT(worst, 0.5); // a voxel: the scheme is of first order
}

TEST(LevelDistance, AllOrNothing) {
    Progress progress;
    const Vec3i n(4, 4, 4);
    EXPECT_TRUE(signedDistance(n, Vec3d(1.0), std::vector<float>(64, -1.0f), progress).empty());
    EXPECT_THROW(signedDistance(n, Vec3d(1.0), std::vector<float>(64, 1.0f), progress), Error);
    EXPECT_EQ(insideShare(n, Vec3d(1.0), {}), 1);
}

TEST(SmoothLevel, KeepsPlanesAndMeans) {
    const Vec3i n(8, 8, 20);
    std::vector<float> level;
    for (int i = 0; i < 64 * 20; ++i) {
        level.push_back(float(i / 64) - 9.3f);
    }
    const auto smooth = smoothLevel(n, level, 1.2);
    for (int z = 9; z < 11; ++z) {
        EXPECT_NEAR(smooth[at(n, 3, 3, z)], level[at(n, 3, 3, z)], 1e-4);
    }
    EXPECT_EQ(smoothLevel(n, level, 0), level);
}

} // namespace
