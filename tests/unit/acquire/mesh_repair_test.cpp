// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_repair.h"

#include "tests/unit/acquire/meshes.h"

#include <limits>

using namespace stf;
using namespace stf::test;

namespace {

TEST(MeshRepair, SoundMeshStaysAsItIs) {
    const MendedMesh m = repair(boxMesh({1, 2, 3}, {5, 5, 5}), "box");
    EXPECT_TRUE(m.repair.sound()) << m.repair.summary();
    EXPECT_EQ(m.repair.pieces, 1u);
    EXPECT_NEAR(m.repair.volume, 6, 1e-12);
    EXPECT_TRUE(m.caps.triangles.empty());
}

TEST(MeshRepair, InvertedMeshIsTurned) {
    const MendedMesh m = repair(turnedOver(boxMesh({1, 2, 3}, {0, 0, 0})), "box");
    EXPECT_EQ(m.repair.turned, 12u);
    EXPECT_NEAR(signedVolume(m.mesh), 6, 1e-12);
}

TEST(MeshRepair, SingleTurnedTrianglesAgreeAgain) {
    TriangleMesh box = boxMesh({1, 2, 3}, {0, 0, 0});
    for (const std::size_t i : {std::size_t(0), std::size_t(5), std::size_t(7)}) {
        std::swap(box.triangles[i].y, box.triangles[i].z);
    }
    const MendedMesh m = repair(box, "box");
    EXPECT_EQ(m.repair.turned, 3u);
    EXPECT_NEAR(m.repair.volume, 6, 1e-12);
}

TEST(MeshRepair, SoupOfTrianglesIsJoined) {
    TriangleMesh soup; // as an STL file has it
    const TriangleMesh box = boxMesh({1, 1, 1}, {0, 0, 0});
    for (std::size_t i = 0; i < box.triangles.size(); ++i) {
        const int first = int(soup.points.size());
        soup.points.insert(soup.points.end(), {box.corner(i, 0), box.corner(i, 1), box.corner(i, 2)});
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    const MendedMesh m = repair(soup, "soup");
    EXPECT_TRUE(m.repair.sound()) << m.repair.summary();
    EXPECT_EQ(m.mesh.points.size(), 8u);
}

TEST(MeshRepair, HoleIsMeasuredAndClosedByAFan) {
    TriangleMesh box = boxMesh({2, 2, 2}, {0, 0, 0});
    box.triangles.resize(10); // without the side x = 1
    const MendedMesh m = repair(box, "box");
    EXPECT_EQ(m.repair.holes, 1u);
    EXPECT_NEAR(m.repair.boundaryMm, 8, 1e-12);
    EXPECT_EQ(m.caps.triangles.size(), 4u);
    EXPECT_NEAR(m.repair.volume, 8, 1e-12) << "the fan of a flat hole is flat";
    EXPECT_NE(m.repair.summary().find("1 hole of 8 mm"), std::string::npos) << m.repair.summary();
}

TEST(MeshRepair, DegenerateAndRepeatedTrianglesAreDropped) {
    TriangleMesh box = boxMesh({1, 1, 1}, {0, 0, 0});
    box.triangles.push_back({3, 3, 4});
    box.triangles.push_back(box.triangles[2]);
    box.triangles.push_back({box.triangles[4].y, box.triangles[4].x, box.triangles[4].z}); // from behind
    const MendedMesh m = repair(box, "box");
    EXPECT_EQ(m.repair.degenerate, 1u);
    EXPECT_EQ(m.repair.duplicates, 2u);
    EXPECT_EQ(m.repair.holes, 0u);
    EXPECT_NEAR(m.repair.volume, 1, 1e-12);
}

TEST(MeshRepair, CavityStaysACavityAndABodyBesideIsTurned) {
    for (const bool inverted : {false, true}) {
        TriangleMesh m = boxMesh({4, 4, 4}, {0, 0, 0});
        append(m, turnedOver(boxMesh({2, 2, 2}, {0, 0, 0})));
        if (inverted) {
            m = turnedOver(m);
        }
        append(m, turnedOver(boxMesh({1, 1, 1}, {10, 0, 0})));
        const MendedMesh r = repair(m, "hollow");
        EXPECT_EQ(r.repair.pieces, 3u);
        EXPECT_NEAR(r.repair.volume, 64 - 8 + 1, 1e-9) << "inverted: " << inverted;
    }
}

TEST(MeshRepair, BadMeshesAreRefusedWithTheElement) {
    TriangleMesh m = boxMesh({1, 1, 1}, {0, 0, 0});
    m.points[6].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(messageOf<Error>([&] { repair(m, "box.obj"); }).find("box.obj: vertex 6"), std::string::npos);
    m.points[6].y = 1e12;
    EXPECT_NE(messageOf<Error>([&] { repair(m, "box.obj"); }).find("vertex 6"), std::string::npos);
    m = boxMesh({1, 1, 1}, {0, 0, 0});
    m.triangles[4].z = 8;
    EXPECT_NE(messageOf<Error>([&] { repair(m, "box.obj"); }).find("triangle 4 names vertex 8"), std::string::npos);
    m.triangles = {{1, 1, 2}};
    EXPECT_NE(messageOf<Error>([&] { repair(m, "box.obj"); }).find("degenerate"), std::string::npos);
    m.triangles.clear();
    EXPECT_NE(messageOf<Error>([&] { repair(m, "box.obj"); }).find("no triangle"), std::string::npos);
}

} // namespace
