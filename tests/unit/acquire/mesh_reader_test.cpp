// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_reader.h"

#include "tests/unit/acquire/meshes.h"

#include <cstring>
#include <limits>
#include <sstream>

using namespace stf;
using namespace stf::test;

namespace {

class MeshFile : public testing::Test {
protected:
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_.file(name), std::ios::binary) << text;
        return folder_.file(name);
    }
    /// The box of 1 x 2 x 3 units about (10, 0, 0), whatever the format: units as given, nothing mirrored.
    void expectBox(const std::string& path) const {
        TriangleMesh all;
        for (const MeshPart& p : readMeshFile(path)) {
            append(all, p.mesh);
        }
        const MendedMesh m = repair(all, path);
        EXPECT_TRUE(m.repair.sound()) << m.repair.summary();
        EXPECT_NEAR(m.repair.volume, 6, 1e-5);
        EXPECT_NEAR(boundsOf(m.mesh).lo.x, 9.5, 1e-6);
        EXPECT_NEAR(boundsOf(m.mesh).hi.z, 1.5, 1e-6);
    }
    std::string complaint(const std::string& path) const {
        const std::string m = messageOf<Error>([&] { readMeshFile(path); });
        EXPECT_EQ(m.rfind(path + ": ", 0), 0u) << m;
        EXPECT_EQ(m.find('\n'), std::string::npos) << m;
        return m;
    }
    const TemporaryFolder folder_;
    const TriangleMesh box_ = boxMesh({1, 2, 3}, {10, 0, 0});
};

std::string objOf(const TriangleMesh& m, const std::string& middle = "") {
    std::ostringstream s;
    for (const Vec3d& p : m.points) {
        s << "v " << p.x << " " << p.y << " " << p.z << "\n";
    }
    s << middle;
    for (const Vec3i& t : m.triangles) {
        s << "f " << t.x + 1 << " " << t.y + 1 << " " << t.z + 1 << "\n";
    }
    return s.str();
}

template<class T>
void put(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string binaryStl(const TriangleMesh& m) {
    std::string s(80, ' ');
    put(s, std::uint32_t(m.triangles.size()));
    for (std::size_t i = 0; i < m.triangles.size(); ++i) {
        for (int k = -1; k < 3; ++k) {
            const Vec3f p = k < 0 ? Vec3f(0, 0, 1) : Vec3f(m.corner(i, k));
            put(s, p.x), put(s, p.y), put(s, p.z);
        }
        put(s, std::uint16_t(0));
    }
    return s;
}

std::string ply(const TriangleMesh& m, bool binary) {
    std::ostringstream head;
    head << "ply\nformat " << (binary ? "binary_little_endian" : "ascii") << " 1.0\nelement vertex " << m.points.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << m.triangles.size()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
    std::string s = head.str();
    std::ostringstream text;
    for (const Vec3d& p : m.points) {
        put(s, float(p.x)), put(s, float(p.y)), put(s, float(p.z));
        text << p.x << " " << p.y << " " << p.z << "\n";
    }
    for (const Vec3i& t : m.triangles) {
        s += '\3';
        put(s, t.x), put(s, t.y), put(s, t.z);
        text << "3 " << t.x << " " << t.y << " " << t.z << "\n";
    }
    return binary ? s : head.str() + text.str();
}

std::string off(const TriangleMesh& m) {
    std::ostringstream s;
    s << "OFF\n" << m.points.size() << " " << m.triangles.size() << " 0\n";
    for (const Vec3d& p : m.points) {
        s << p.x << " " << p.y << " " << p.z << "\n";
    }
    for (const Vec3i& t : m.triangles) {
        s << "3 " << t.x << " " << t.y << " " << t.z << "\n";
    }
    return s.str();
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

TEST_F(MeshFile, Obj) {
    expectBox(write("box.obj", objOf(box_)));
}

TEST_F(MeshFile, ObjOfPolygons) {
    // Quads, and the numbers of OBJ from the end.
    expectBox(
        write("quads.obj",
              "v 9.5 -1 -1.5\nv 10.5 -1 -1.5\nv 9.5 1 -1.5\nv 10.5 1 -1.5\nv 9.5 -1 1.5\nv 10.5 -1 1.5\n"
              "v 9.5 1 1.5\nv 10.5 1 1.5\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf -7 -5 -1 -3\n"));
}

TEST_F(MeshFile, ConcavePolygonsAreCoveredOnce) {
    // A comb of two teeth in the plane z = 0, of area 9: a fan about its first corner would leave the shape.
    const std::string points = "5 3 0\n4 3 0\n4 1 0\n1 1 0\n1 3 0\n0 3 0\n0 0 0\n5 0 0\n";
    const std::string face = "8 0 1 2 3 4 5 6 7\n";
    const std::string files[] = {
        write("comb.off", "OFF\n8 1 0\n" + points + face),
        write("comb.ply", "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
                          "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                              points + face)};
    for (const std::string& path : files) {
        const TriangleMesh mesh = readMeshFile(path).at(0).mesh;
        EXPECT_EQ(mesh.triangles.size(), 6u) << path;
        double sum = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const double z = cross(mesh.corner(t, 1) - mesh.corner(t, 0), mesh.corner(t, 2) - mesh.corner(t, 0)).z;
            EXPECT_GE(z, 0) << path;
            sum += std::abs(z) / 2;
        }
        EXPECT_NEAR(sum, 9, 1e-9) << path;
    }
}

TEST_F(MeshFile, PlyInTextAndBinary) {
    expectBox(write("text.ply", ply(box_, false)));
    expectBox(write("binary.ply", ply(box_, true)));
}

TEST_F(MeshFile, StlInTextAndBinary) {
    expectBox(write("binary.stl", binaryStl(box_)));
    std::ostringstream s;
    s << "solid box\n";
    for (std::size_t i = 0; i < box_.triangles.size(); ++i) {
        s << "facet normal 0 0 0\nouter loop\n";
        for (int k = 0; k < 3; ++k) {
            const Vec3d& p = box_.corner(i, k);
            s << "vertex " << p.x << " " << p.y << " " << p.z << "\n";
        }
        s << "endloop\nendfacet\n";
    }
    expectBox(write("text.stl", s.str() + "endsolid box\n"));
}

TEST_F(MeshFile, Off) {
    expectBox(write("box.off", off(box_)));
    expectBox(write("beside.off", "# a comment\n" + replaced(off(box_), "OFF\n", "OFF ")));
}

TEST_F(MeshFile, PartsAndTheirMaterialsAreNamed) {
    write("m.mtl", "newmtl Marble\nKd 1 1 1\nnewmtl Ketchup\nKd 1 0 0\n");
    TriangleMesh two = box_;
    std::string text = "mtllib m.mtl\n" + objOf(box_, "o left\nusemtl Marble\n");
    for (const Vec3d& p : boxMesh({1, 1, 1}, {0, 0, 0}).points) {
        text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    }
    text += "o right\nusemtl Ketchup\n";
    for (const Vec3i& t : box_.triangles) {
        text += "f " + std::to_string(t.x + 9) + " " + std::to_string(t.y + 9) + " " + std::to_string(t.z + 9) + "\n";
    }
    const std::string path = write("two.obj", text);
    const std::vector<MeshPart> parts = readMeshFile(path);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_EQ(parts[0].name, "left");
    EXPECT_EQ(parts[0].material, "Marble");
    EXPECT_EQ(parts[1].name, "right");
    EXPECT_EQ(parts[1].material, "Ketchup");
    // A recipe without a material takes them; with a part, only that.
    const auto recipe = [&](const std::string& more) {
        Progress progress;
        const std::string text2 = R"({"size": [64, 16, 16], "voxel": 0.25, "meshes": [{"file": ")" + path +
                                  R"(", "translate": [2, 2, -2])" + more + "}]}";
        return acquireMesh(parseMeshRecipe(text2, "r", ""), [](const std::string& p) { return readMeshFile(p); }, 1e9,
                           progress, {});
    };
    const MeshAcquisition both = recipe(""), one = recipe(R"(, "part": "right", "material": "Coke")");
    EXPECT_NEAR(shareOf(both, "Marble"), 6.0 / 256, 1e-5);
    EXPECT_NEAR(shareOf(both, "Ketchup"), 1.0 / 256, 1e-5);
    EXPECT_EQ(shareOf(one, "Marble"), 0);
    EXPECT_EQ(one.shares.size(), 1u);
    EXPECT_NE(messageOf<Error>([&] { recipe(R"(, "part": "rihgt", "material": "Coke")"); }).find("right"),
              std::string::npos);
}

TEST_F(MeshFile, BadFilesAreRefused) {
    EXPECT_NE(complaint(folder_.file("none.obj")).find("no such file"), std::string::npos);
    EXPECT_NE(complaint(write("a.blend", "x")).find("ending"), std::string::npos);
    complaint(write("empty.obj", ""));
    complaint(write("empty.ply", ""));
    complaint(write("empty.stl", ""));
    complaint(write("empty.off", ""));
    complaint(write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"));
    complaint(write("text.ply", "This is a text."));
    const std::string whole = ply(box_, true), stl = binaryStl(box_);
    for (std::size_t length = 0; length < whole.size(); length += 3) {
        complaint(write("cut.ply", whole.substr(0, length)));
    }
    for (const char* ending : {".ply", ".off"}) {
        const std::string text = ending[1] == 'p' ? ply(box_, false) : off(box_);
        for (std::size_t length = 0; length + 6 < text.size(); length += 3) { // not within the last face
            complaint(write(std::string("cut") + ending, text.substr(0, length)));
        }
        EXPECT_NE(complaint(write(std::string("many") + ending,
                                  replaced(text, ending[1] == 'p' ? "vertex 8" : "8 12",
                                           ending[1] == 'p' ? "vertex 4000000000" : "4000000000 12")))
                      .find("promises"),
                  std::string::npos);
        EXPECT_NE(complaint(write(std::string("far") + ending, replaced(text, "3 0 2 1", "3 0 99 1"))).find("99"),
                  std::string::npos);
        const std::string nan = write(std::string("nan") + ending, replaced(text, "10.5 -1 -1.5", "10.5 nan -1.5"));
        EXPECT_NE(messageOf<Error>([&] { repair(readMeshFile(nan)[0].mesh, nan); }).find("vertex 1"),
                  std::string::npos);
    }
    complaint(write("cut.stl", stl.substr(0, stl.size() / 2)));
    EXPECT_NE(messageOf<Error>([&] { readMeshFile(write("big.obj", objOf(box_)), 50); }).find("MB"), std::string::npos);
}

} // namespace
