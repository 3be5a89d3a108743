// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_cover.h"

#include "stfLib/acquire/mesh_distance.h"
#include "stfLib/base/parallel.h"
#include "tests/unit/acquire/meshes.h"

using namespace stf;
using namespace stf::test;

namespace {

constexpr double kExact = 1e-5;

// A tile of 40 x 40 x 40 voxels of 0.1 mm; a mesh "a" in it.
std::string tile(const std::string& meshes, const std::string& more = "") {
    return R"({"size": [40, 40, 40], "voxel": 0.1, "matrix": {"name": "m", "sigma_s": 1.5, "sigma_a": [0.1, 0.2, 0.3]},)" +
           more + R"( "meshes": [)" + meshes + "]}";
}
const char* const kInclusion = R"({"file": "a", "material": {"name": "i", "sigma_s": 8, "sigma_a": [0.5, 0.01, 2]}})";

double meanOf(const BaseVolume& v, bool scattering, int channel) {
    double sum = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const double albedo = double(v.albedo[i][channel]);
        sum += double(v.extinction[i][channel]) * (scattering ? albedo : 1 - albedo);
    }
    return sum / double(v.voxelCount());
}

TEST(MeshCover, SphereHasItsVolumeAndTheTileItsMeanCoefficients) {
    const Acquired a = acquired(tile(kInclusion), {sphereMesh(1.6, {2.013, 1.972, -1.991})});
    const double f = 4.0 / 3 * kPi * std::pow(1.6, 3) / 64;
    EXPECT_NEAR(shareOf(a, "i"), f, 0.002 * f);
    EXPECT_NEAR(shareOf(a, "i") + shareOf(a, "m"), 1, kExact);
    EXPECT_NEAR(a.meshes[0].volumeMm3, f * 64, 0.002 * f * 64);
    EXPECT_NEAR(shareOf(a, "i"), a.meshes[0].volumeMm3 / 64, 1e-4 * f) << "the mesh's own volume, exactly";
    const Vec3d matrix(0.1, 0.2, 0.3), inclusion(0.5, 0.01, 2);
    for (int c = 0; c < 3; ++c) {
        const double sigmaS = 1.5 + f * (8 - 1.5), sigmaA = matrix[c] + f * (inclusion[c] - matrix[c]);
        EXPECT_NEAR(meanOf(a.volume, true, c), sigmaS, 0.005 * sigmaS);
        EXPECT_NEAR(meanOf(a.volume, false, c), sigmaA, 0.005 * sigmaA);
    }
}

TEST(MeshCover, BoxBetweenVoxelsIsExactToAHundredthOfAVoxel) {
    for (const double shift : {0.0, 0.033, 0.0501, 0.097}) {
        const Vec3d size(1.037, 0.731, 1.377);
        const Acquired a = acquired(tile(kInclusion), {boxMesh(size, Vec3d(2, 2, -2) + Vec3d(shift))});
        const double f = size.x * size.y * size.z / 64;
        EXPECT_NEAR(shareOf(a, "i"), f, 0.004 * f) << shift;
    }
}

TEST(MeshCover, WhatCrossesASideComesInOnTheOther) {
    const Acquired middle = acquired(tile(kInclusion), {sphereMesh(1.2, {2, 2, -2}, 4)});
    const Acquired side = acquired(tile(kInclusion), {sphereMesh(1.2, {4, 0, -2}, 4)});
    const BaseVolume &v = middle.volume, &w = side.volume;
    double worst = 0;
    for (int z = 0; z < 40; ++z) {
        for (int y = 0; y < 40; ++y) {
            for (int x = 0; x < 40; ++x) {
                worst = std::max(worst, std::abs(double(v.extinction[v.index(x, y, z)].x) -
                                                 double(w.extinction[w.index((x + 20) % 40, (y + 20) % 40, z)].x)));
            }
        }
    }
    EXPECT_LT(worst, 1e-4) << "up to rounding of the places";
    EXPECT_NEAR(shareOf(side, "i"), shareOf(middle, "i"), 1e-7);
}

TEST(MeshCover, HigherPriorityWinsAndOfEqualsTheLater) {
    const std::vector<TriangleMesh> boxes{boxMesh({2, 2, 2}, {1.5, 2, -2}), boxMesh({2, 2, 2}, {2.5, 2, -2})};
    const auto both = [&](int first, int second) {
        return acquired(tile(R"({"file": "a", "material": {"name": "p", "sigma_s": 1}, "priority": )" +
                             std::to_string(first) +
                             R"(}, {"file": "b", "material": {"name": "q", "sigma_s": 1}, "priority": )" +
                             std::to_string(second) + "}"),
                        boxes);
    };
    for (const auto& [first, second] : {std::pair(0, 0), std::pair(1, 2), std::pair(2, 1)}) {
        const Acquired a = both(first, second);
        const bool firstWins = first > second;
        EXPECT_NEAR(shareOf(a, "p"), (firstWins ? 8.0 : 4.0) / 64, kExact);
        EXPECT_NEAR(shareOf(a, "q"), (firstWins ? 4.0 : 8.0) / 64, kExact);
        EXPECT_NEAR(shareOf(a, "m"), 1 - 12.0 / 64, kExact);
    }
}

TEST(MeshCover, OverlapsOfOneMeshCountOnce) {
    TriangleMesh m = boxMesh({2, 2, 2}, {1.5, 2, -2});
    append(m, boxMesh({2, 2, 2}, {2.5, 2, -2}));
    const Acquired a = acquired(tile(kInclusion), {m});
    EXPECT_NEAR(shareOf(a, "i"), 12.0 / 64, kExact);
}

TEST(MeshCover, InvertedMeshIsTheSame) {
    const TriangleMesh m = sphereMesh(1.3, {2, 2, -2}, 3);
    EXPECT_EQ(acquired(tile(kInclusion), {m}).volume.contentHash(),
              acquired(tile(kInclusion), {turnedOver(m)}).volume.contentHash());
}

TEST(MeshCover, SmallHoleHardlyMatters) {
    TriangleMesh m = sphereMesh(1.5, {2, 2, -2}, 4), open = m;
    open.triangles.clear();
    for (std::size_t i = 0; i < m.triangles.size(); ++i) {
        if (m.corner(i, 0).z < -2 + 1.4) {
            open.triangles.push_back(m.triangles[i]);
        }
    }
    ASSERT_LT(open.triangles.size(), m.triangles.size() - 50);
    const Acquired whole = acquired(tile(kInclusion), {m}), holed = acquired(tile(kInclusion), {open});
    EXPECT_EQ(holed.meshes[0].repair.holes, 1u);
    ASSERT_EQ(holed.messages.size(), 1u);
    EXPECT_NE(holed.messages[0].find("1 hole"), std::string::npos) << holed.messages[0];
    EXPECT_NEAR(shareOf(holed, "i"), shareOf(whole, "i"), 0.01 * shareOf(whole, "i"));
    const auto inside = [](const Acquired& a) { return a.volume.extinction[a.volume.index(20, 20, 20)].x; };
    EXPECT_EQ(inside(holed), inside(whole));
}

TEST(MeshCover, OpenMeshIsInsideWhereItsWindingNumberExceedsAHalf) {
    // A hemisphere without a bottom, against the direct sum over its triangles at points of a lattice.
    TriangleMesh m = sphereMesh(1.5, {2, 2, -2}, 3), open = m;
    open.triangles.clear();
    for (std::size_t i = 0; i < m.triangles.size(); ++i) {
        if (std::max({m.corner(i, 0).z, m.corner(i, 1).z, m.corner(i, 2).z}) < -2.0) {
            open.triangles.push_back(m.triangles[i]);
        }
    }
    TriangleMesh inTile = open; // depth grows inward
    for (Vec3d& p : inTile.points) {
        p.z = -p.z;
    }
    inTile = turnedOver(inTile);
    const TriangleTree tree(inTile);
    const TileGrid grid{{20, 20, 20}, Vec3d(0.2)};
    MendedMesh placed = repair(inTile, "bowl");
    const MeshColumns columns(std::move(placed), grid);
    const std::vector<Vec2d> lines{{0.31, 0.43}};
    int wrong = 0, inside = 0, compared = 0;
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 20; ++x) {
            std::vector<Stretch> stretches;
            columns.inside(x, y, lines, stretches);
            for (int k = 0; k < 200; ++k) {
                const double z = (k + 0.5) * 0.02;
                const Vec3d p((x + 0.31) * 0.2, (y + 0.43) * 0.2, z);
                const double w = tree.windingNumber(p);
                // Beside a hole a voxel is asked at 4 x 4 x 4 places: its border is known to a quarter of a voxel.
                bool border = std::abs(w - 0.5) < 0.05;
                for (int side = 0; side < 6 && !border; ++side) {
                    Vec3d q = p;
                    q[side / 2] += side % 2 ? 0.06 : -0.06;
                    border = (tree.windingNumber(q) > 0.5) != (w > 0.5);
                }
                if (border) {
                    continue;
                }
                const bool in = std::any_of(stretches.begin(), stretches.end(),
                                            [&](const Stretch& s) { return s.from <= z && z < s.to; });
                wrong += in != (w > 0.5);
                inside += w > 0.5;
                ++compared;
            }
        }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(compared, 70000);
    EXPECT_LE(wrong, compared / 5000) << "of " << compared;
}

TEST(MeshCover, ThreadsDoNotMatter) {
    const std::string recipe =
        tile(R"({"shape": "pebble", "material": {"name": "i", "sigma_s": 9}, "scatter": {"count": 30, "seed": 3,
             "scale": [0.3, 0.9]}}, {"shape": "sphere", "material": "none", "surface": true, "translate": [2, 2, -1]})");
    std::string hash[2];
    for (int threads : {1, 2}) {
        setThreadCount(threads);
        hash[threads - 1] = acquired(recipe).volume.contentHash();
    }
    setThreadCount(0);
    EXPECT_EQ(hash[0], hash[1]);
}

TEST(MeshCover, VoidWithoutASurfaceTakesItsShareOfTheCoefficients) {
    const Acquired a = acquired(tile(R"({"file": "a", "material": "none"})"), {boxMesh({2, 2, 2}, {2, 2, -2})});
    EXPECT_TRUE(a.volume.surface.empty());
    EXPECT_NEAR(meanOf(a.volume, true, 0), 1.5 * (1 - 8.0 / 64), 1e-4);
    EXPECT_EQ(a.volume.extinction[a.volume.index(20, 20, 20)].x, 0);
}

TEST(MeshCover, CancelThrows) {
    Progress progress;
    progress.cancel();
    const MeshRecipe r = parseMeshRecipe(tile(""), "recipe", "");
    EXPECT_THROW(acquireMesh(r, [](const std::string& path) { return readMeshFile(path); }, 1e9, progress, {}),
                 Cancelled);
}

} // namespace
