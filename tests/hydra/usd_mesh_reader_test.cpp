// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/usd_mesh_reader.h"

#include "stfLib/base/temporary_folder.h"

#include <fstream>
#include <gtest/gtest.h>

using namespace stf;

namespace {

class UsdMeshFile : public testing::Test {
protected:
    std::vector<MeshPart> read(const std::string& text, const std::string& name = "scene.usda") {
        std::ofstream(folder_.file(name)) << text;
        return readUsdMeshes(folder_.file(name), [this](Severity, const std::string& t) { messages_.push_back(t); });
    }
    std::string complaint(const std::string& text) {
        try {
            read(text);
        } catch (const Error& e) {
            EXPECT_EQ(std::string(e.what()).rfind(folder_.file("scene.usda"), 0), 0u) << e.what();
            return e.what();
        }
        ADD_FAILURE() << "nothing was thrown";
        return {};
    }
    const TemporaryFolder folder_;
    std::vector<std::string> messages_;
};

std::string cube(const std::string& scheme, const std::string& more = "") {
    return R"(
        int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
        int[] faceVertexIndices = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
        point3f[] points = [(-1, -1, -1), (-1, -1, 1), (-1, 1, -1), (-1, 1, 1), (1, -1, -1), (1, -1, 1), (1, 1, -1), (1, 1, 1)]
        uniform token subdivisionScheme = ")" +
           scheme + "\"\n" + more;
}

TEST_F(UsdMeshFile, WorldSpaceInMillimetresWithZUp) {
    const auto parts = read(R"(#usda 1.0
( metersPerUnit = 0.01
  upAxis = "Y" )
def Xform "World" {
    double3 xformOp:translate = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "Cube" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {
        rel material:binding = </Marble>)" +
                            cube("none") + R"(
    }
    def Mesh "Hidden" { token visibility = "invisible" )" +
                            cube("none") + R"( }
    def Mesh "Guide" { uniform token purpose = "guide" )" +
                            cube("none") + R"( }
    def Sphere "Ball" {}
}
def Material "Marble" {})");
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].name, "Cube");
    EXPECT_EQ(parts[0].path, "/World/Cube");
    EXPECT_EQ(parts[0].material, "Marble");
    const Box3d box = boundsOf(parts[0].mesh);
    // (x, y, z) of y up becomes (x, -z, y); a unit is a centimetre.
    EXPECT_NEAR(length(box.middle() - Vec3d(10, -30, 20)), 0, 1e-5);
    EXPECT_NEAR(signedVolume(parts[0].mesh), 8000, 1e-2) << "faces outward as authored";
    ASSERT_EQ(messages_.size(), 1u);
    EXPECT_NE(messages_[0].find("1 prims that are not meshes"), std::string::npos) << messages_[0];
}

TEST_F(UsdMeshFile, SubdivisionSurfaceIsItsLimit) {
    const auto parts =
        read("#usda 1.0\n( metersPerUnit = 0.001\n upAxis = \"Z\" )\ndef Mesh \"Cube\" {" + cube("catmullClark") + "}");
    ASSERT_EQ(parts.size(), 1u);
    // The limit of a corner of valence 3 is (9 v + 4 sum of its neighbours + sum of the corners across its faces) / 24
    // (Halstead et al. 1993), of the sum of coordinates (9 * 3 + 4 * 3 * 1 - 3) / 24.
    const Box3d box = boundsOf(parts[0].mesh);
    EXPECT_LT(box.hi.x, 0.9);
    EXPECT_GT(parts[0].mesh.triangles.size(), 500u);
    double farthest = 0;
    for (const Vec3d& p : parts[0].mesh.points) {
        farthest = std::max(farthest, p.x + p.y + p.z);
    }
    EXPECT_NEAR(farthest, 1.5, 1e-5);
}

TEST_F(UsdMeshFile, InstancesAreAllThere) {
    const auto parts = read(R"(#usda 1.0
( metersPerUnit = 0.001
  upAxis = "Z" )
class "Proto" {
    def Mesh "Cube" {)" + cube("none") +
                            R"(
    }
}
def Xform "A" ( instanceable = true
  inherits = </Proto> ) {}
def Xform "B" ( instanceable = true
  inherits = </Proto> ) {
    double3 xformOp:translate = (5, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
})");
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_NEAR(boundsOf(parts[1].mesh).middle().x - boundsOf(parts[0].mesh).middle().x, 5, 1e-6);
}

TEST_F(UsdMeshFile, BadFilesAreRefused) {
    complaint("not usd");
    EXPECT_NE(complaint("#usda 1.0\ndef Xform \"X\" {}").find("no visible mesh"), std::string::npos);
    EXPECT_NE(
        complaint("#usda 1.0\ndef Mesh \"M\" { int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n"
                  "point3f[] points = [(0, 0, 0), (nan, 0, 0), (0, 1, 0)]\n }")
            .find("/M: vertex 1"),
        std::string::npos);
    EXPECT_NE(complaint("#usda 1.0\ndef Mesh \"M\" {}").find("/M"), std::string::npos);
    EXPECT_THROW(readUsdMeshes(folder_.file("nowhere.usda"), {}), Error);
}

} // namespace
