// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_distance.h"

#include "stfLib/base/random.h"
#include "stfLib/transport/surface_field.h"
#include "tests/unit/acquire/meshes.h"

using namespace stf;
using namespace stf::test;

namespace {

const Vec3d kMiddle(2.013, 1.972, 1.991); // depth inward
constexpr double kVoxel = 0.1, kRadius = 16 * kVoxel;

std::string bodies(const std::string& meshes) {
    return R"({"size": [40, 40, 40], "voxel": 0.1, "matrix": {"sigma_s": 2}, "top": "geometry", "meshes": [)" + meshes +
           "]}";
}

/// A sphere of 32 voxels across as the body.
Acquired sphere() {
    return acquired(bodies(R"({"file": "a", "material": {"sigma_s": 1}, "body": true})"),
                    {sphereMesh(kRadius, {kMiddle.x, kMiddle.y, -kMiddle.z}, 6)});
}

double angle(const Vec3d& a, const Vec3d& b) {
    return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / kPi;
}

TEST(MeshDistance, IsThatOfASphere) {
    const BaseVolume v = sphere().volume;
    for (int z = 0; z < 40; ++z) {
        for (int y = 0; y < 40; ++y) {
            for (int x = 0; x < 40; ++x) {
                Vec3d d = Vec3d(x + 0.5, y + 0.5, z + 0.5) * kVoxel - kMiddle;
                d.x -= 4 * std::round(d.x / 4);
                d.y -= 4 * std::round(d.y / 4);
                // The facets lie within 0.0005 of the sphere.
                ASSERT_NEAR(v.surface[v.index(x, y, z)], length(d) - kRadius, 6e-4) << x << " " << y << " " << z;
            }
        }
    }
}

// Central differences, trilinear between the middles of voxels, on the sphere.
TEST(MeshDistance, NormalsOfTheFieldAreWithinHalfADegreeOfTheSphere) {
    const BaseVolume v = sphere().volume;
    const auto at = [&](int x, int y, int z) { return double(v.surface[v.index(x, y, z)]); };
    const auto gradient = [&](int x, int y, int z) {
        return Vec3d(at(x + 1, y, z) - at(x - 1, y, z), at(x, y + 1, z) - at(x, y - 1, z),
                     at(x, y, z + 1) - at(x, y, z - 1));
    };
    CounterRng rng(5, 0);
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
        const double c = 2 * double(rng.uniform()) - 1, a = 2 * kPi * double(rng.uniform()), s = std::sqrt(1 - c * c);
        const Vec3d n(s * std::cos(a), s * std::sin(a), c);
        const Vec3d p = (kMiddle + n * kRadius) / kVoxel - Vec3d(0.5);
        const Vec3i b(int(p.x), int(p.y), int(p.z));
        const Vec3d f = p - Vec3d(b);
        Vec3d sum;
        for (int k = 0; k < 8; ++k) {
            const double w = ((k & 1) ? f.x : 1 - f.x) * ((k & 2) ? f.y : 1 - f.y) * ((k & 4) ? f.z : 1 - f.z);
            sum += gradient(b.x + (k & 1), b.y + (k >> 1 & 1), b.z + (k >> 2)) * w;
        }
        worst = std::max(worst, angle(sum, n));
    }
    EXPECT_LT(worst, 0.5);
}

// The normals that light is refracted with: the gradient of the trilinear field jumps between cells, on a sphere of
// radius R voxels by up to 1 / R; what is left is that of the interpolation, not of the distances.
TEST(MeshDistance, NormalsOfTheRendererAreAsGoodAsTheyAreOnExactDistances) {
    const BaseVolume v = sphere().volume;
    std::vector<float> exact(v.voxelCount());
    for (std::size_t i = 0; i < exact.size(); ++i) {
        const Vec3d d =
            Vec3d(double(i % 40) + 0.5, double(i / 40 % 40) + 0.5, double(i / 1600) + 0.5) * kVoxel - kMiddle;
        exact[i] = float(length(d) - kRadius);
    }
    const SurfaceField field(v.size, v.voxelMm, v.surface), best(v.size, v.voxelMm, exact);
    CounterRng rng(6, 0);
    double squares = 0, bestSquares = 0;
    for (int i = 0; i < 4000; ++i) {
        const double c = 2 * double(rng.uniform()) - 1, a = 2 * kPi * double(rng.uniform()), s = std::sqrt(1 - c * c);
        const Vec3d n(s * std::cos(a), s * std::sin(a), c);
        const Vec3f p((kMiddle + n * kRadius) / kVoxel);
        squares += std::pow(angle(Vec3d(field.normal(p)), n), 2) / 4000;
        bestSquares += std::pow(angle(Vec3d(best.normal(p)), n), 2) / 4000;
    }
    EXPECT_LT(std::sqrt(squares), 2);
    EXPECT_NEAR(std::sqrt(squares), std::sqrt(bestSquares), 0.05);
}

TEST(MeshDistance, VoidIsCutOutOfTheFlatTile) {
    const Acquired a =
        acquired(R"({"size": [40, 40, 40], "voxel": 0.1, "matrix": {"sigma_s": 2, "ior": 1.31}, "meshes": [
        {"file": "a", "material": "none", "surface": true}]})",
                 {sphereMesh(1, {2, 2, -2}, 5)});
    const BaseVolume& v = a.volume;
    for (int z = 0; z < 40; ++z) {
        const double d = 1 - length(Vec3d(0.05, 0.05, (z + 0.5) * 0.1 - 2));
        EXPECT_NEAR(v.surface[v.index(20, 20, z)], std::max(d, -(z + 0.5) * 0.1), 0.002) << z;
        // A cut voxel holds the coefficients of what is inside: nothing is lost, nothing is thin.
        if (v.surface[v.index(20, 20, z)] < -0.1) {
            EXPECT_FLOAT_EQ(v.extinction[v.index(20, 20, z)].x, 2);
        }
    }
    EXPECT_FLOAT_EQ(v.ior[v.index(0, 0, 20)], 1.31f);
}

TEST(MeshDistance, ReliefIsTheUpperEnvelopeOfAnOpenSheet) {
    // A wave of 64 strips, without sides or a bottom.
    TriangleMesh sheet;
    const auto height = [](double x) { return -1 - 0.5 * std::cos(2 * kPi * x / 4); };
    for (int i = 0; i <= 64; ++i) {
        for (const double y : {0.0, 4.0}) {
            sheet.points.push_back({i / 16.0, y, height(i / 16.0)});
        }
    }
    for (int i = 0; i < 64; ++i) {
        sheet.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
        sheet.triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
    }
    const Acquired a = acquired(R"({"size": [40, 40, 40], "voxel": 0.1, "matrix": {"name": "m", "sigma_s": 2},
                                   "top": {"file": "a"}})",
                                {sheet});
    EXPECT_NEAR(shareOf(a, "m"), 0.75, 0.001) << "the mean of the cosine is 0";
    const BaseVolume& v = a.volume;
    for (int z = 0; z < 40; ++z) {
        for (int x = 0; x < 40; ++x) {
            const double below = (z + 0.5) * 0.1 + height((x + 0.5) * 0.1), d = v.surface[v.index(x, 7, z)];
            if (std::abs(below) > 0.01) {
                EXPECT_EQ(d<0, below> 0) << x << " " << z;
            }
            EXPECT_LE(std::abs(d), std::abs(below) + 6e-4) << "no further than straight up, chords for arcs";
            EXPECT_GE(std::abs(d) * std::sqrt(1 + std::pow(0.25 * kPi, 2)) + 0.01, std::abs(below))
                << "the steepest slope";
        }
    }
}

TEST(MeshDistance, ReliefOfABodyKnowsNothingOfItsUndersideAndStandsOnAFloor) {
    // A slab from depth 0.5 to 1.5 over the left half; to its right the floor, as deep as the slab reaches.
    const Acquired a = acquired(R"({"size": [40, 40, 40], "voxel": 0.1, "matrix": {"name": "m", "sigma_s": 2},
                                   "top": {"file": "a"}})",
                                {boxMesh({2, 4, 1}, {1, 2, -1})});
    EXPECT_NEAR(shareOf(a, "m"), 0.5 * (3.5 + 2.5) / 4, 1e-4);
    ASSERT_EQ(a.messages.size(), 1u);
    EXPECT_NE(a.messages[0].find("leaves 50 %"), std::string::npos) << a.messages[0];
    const BaseVolume& v = a.volume;
    for (int z = 0; z < 40; ++z) {
        const double depth = (z + 0.5) * 0.1;
        if (depth < 1.4) { // further down the floor beside it is nearer than the top
            EXPECT_NEAR(v.surface[v.index(10, 20, z)], 0.5 - depth, 1e-5) << z;
        }
        if (depth > 0.6) {
            EXPECT_NEAR(v.surface[v.index(30, 20, z)], 1.5 - depth, 1e-5) << z;
        }
        if (depth > 0.9 && depth < 1.1) { // beside its walls, on both sides
            for (const int x : {22, 37}) {
                EXPECT_NEAR(v.surface[v.index(x, 20, z)], 0.25, 1e-5) << x;
                EXPECT_NEAR(v.surface[v.index(x == 22 ? 17 : 2, 20, z)], -0.25, 1e-5) << x;
            }
        }
    }
}

TEST(MeshDistance, WallsBetweenNeighbouringTilesAreNoSurface) {
    const Acquired a = acquired(bodies(R"({"file": "a", "material": {"sigma_s": 1}, "body": true})"),
                                {boxMesh({4, 4, 3}, {2, 2, -2.5})}); // from depth 1 to the bottom
    const BaseVolume& v = a.volume;
    for (int z = 0; z < 40; ++z) {
        EXPECT_NEAR(v.surface[v.index(0, 0, z)], 1 - (z + 0.5) * 0.1, 1e-6) << z;
    }
}

TEST(MeshDistance, SolidThatStandsOutOfTheBodyIsJoinedToIt) {
    const Acquired a =
        acquired(bodies(R"({"file": "a", "material": {"sigma_s": 1}, "body": true},
                                         {"file": "b", "material": {"name": "stud", "sigma_s": 5}, "priority": 1},
                                         {"file": "c", "material": {"name": "pit", "sigma_s": 6}, "priority": 1})"),
                 {boxMesh({4, 4, 3}, {2, 2, -2.5}), sphereMesh(0.5, {2, 2, -1}, 4), sphereMesh(0.4, {1, 1, -3}, 4)});
    const BaseVolume& v = a.volume;
    EXPECT_LT(v.surface[v.index(20, 20, 6)], 0) << "within the stud, above the body";
    EXPECT_NEAR(v.surface[v.index(20, 20, 3)], 0.15, 0.01) << "0.5 above the middle of the stud";
    EXPECT_NEAR(v.surface[v.index(0, 0, 3)], 0.65, 0.01) << "the body is level elsewhere";
    EXPECT_NEAR(v.extinction[v.index(10, 10, 30)].x, 6, 1e-5);
    EXPECT_LT(v.surface[v.index(10, 10, 26)], -0.5) << "an inclusion is no surface";
}

} // namespace
