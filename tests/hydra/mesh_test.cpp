// SPDX-License-Identifier: Apache-2.0
#include "hdStf/meshData.h"
#include "hdStf/primvars.h"

#include "test_host.h"

#include "pxr/usd/usdGeom/mesh.h"

#include "pxr/imaging/hd/tokens.h"

#include <gtest/gtest.h>

#include <algorithm>

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

TEST(Mesh, WeldingKeepsSeamsAndJoinsTheRest) {
    // Two quads that share an edge (vertices 1 and 2), the second one with other coordinates at vertex 2.
    const VtIntArray vertices{0, 1, 2, 3, 1, 4, 5, 2};
    std::vector<stf::Vec2f> uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {1, 0}, {2, 0}, {2, 1}, {5, 5}};
    const std::vector<stf::Vec2f> flat = uvs;
    const std::vector<int> indices = HdStfWeldUvs(vertices, uvs);
    EXPECT_EQ(uvs.size(), 7u);
    EXPECT_EQ(indices[1], indices[4]);
    EXPECT_NE(indices[2], indices[7]);
    for (size_t i = 0; i < flat.size(); ++i) {
        EXPECT_EQ(uvs[size_t(indices[i])], flat[i]);
    }
}

TEST(Mesh, TopologyAndTagsArrive) {
    TestHost host(testScene(R"(
        uniform token orientation = "leftHanded"
        uniform token subdivisionScheme = "catmullClark"
        uniform token interpolateBoundary = "edgeOnly"
        int[] cornerIndices = [0]; float[] cornerSharpnesses = [3]
        int[] creaseIndices = [0, 1, 2]; int[] creaseLengths = [3]; float[] creaseSharpnesses = [2]
        int[] holeIndices = [0])"));
    host.execute();
    const stf::ControlMesh& mesh = *host.mesh("/Square").mesh;
    EXPECT_EQ(mesh.scheme, stf::ControlMesh::Scheme::CatmullClark);
    EXPECT_TRUE(mesh.leftHanded);
    EXPECT_EQ(mesh.interpolateBoundary, "edgeOnly");
    EXPECT_EQ(mesh.holeIndices, std::vector<int>{0});
    EXPECT_EQ(mesh.cornerIndices, std::vector<int>{0});
    EXPECT_EQ(mesh.creaseIndices, (std::vector<int>{0, 1, 2}));
    EXPECT_EQ(mesh.creaseSharpnesses, std::vector<float>{2});
}

TEST(Mesh, VertexCoordinatesGoByTheVertices) {
    TestHost host(testScene(R"(
        float2[] primvars:UVMap = [(9, 9), (9, 9), (9, 9), (9, 9)] (interpolation = "vertex")
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "varying"))"));
    host.execute();
    const stf::ControlMesh& mesh = *host.mesh("/Square").mesh;
    ASSERT_EQ(mesh.uvs.size(), 4u);
    EXPECT_EQ(mesh.uvs[2], stf::Vec2f(1, 1));
    EXPECT_EQ(mesh.uvIndices, mesh.faceVertexIndices);
}

TEST(Mesh, AnyTextureCoordinateByRoleWillDo) {
    TestHost host(testScene(R"(
        texCoord2f[] primvars:mine = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying"))"));
    host.execute();
    EXPECT_EQ(host.mesh("/Square").mesh->uvs.size(), 4u);
}

TEST(Mesh, ColorsOfAllInterpolations) {
    using Interpolation = stf::ControlMesh::Interpolation;
    const std::pair<const char*, Interpolation> cases[] = {{"constant", Interpolation::Constant},
                                                           {"uniform", Interpolation::Uniform},
                                                           {"vertex", Interpolation::Vertex},
                                                           {"faceVarying", Interpolation::FaceVarying}};
    for (const auto& [name, interpolation] : cases) {
        const bool one = interpolation == Interpolation::Constant || interpolation == Interpolation::Uniform;
        TestHost host(testScene(std::string("color3f[] primvars:displayColor = [(1, 0, 0)") +
                                (one ? "" : ", (0, 1, 0), (0, 0, 1), (1, 1, 1)") + "] (interpolation = \"" + name +
                                "\")"));
        host.execute();
        const stf::ControlMesh& mesh = *host.mesh("/Square").mesh;
        EXPECT_EQ(mesh.colorInterpolation, interpolation);
        EXPECT_EQ(mesh.colors.size(), one ? 1u : 4u);
    }
}

// UsdImaging of 20.08 names a primvar under interpolations that it no longer has.
TEST(Mesh, NumbersTellInterpolationsApart) {
    HdStfPrimvarDescriptors descriptors;
    const auto name = [&descriptors](const char* primvar, HdInterpolation interpolation) {
        descriptors[size_t(std::find(HdStfInterpolations.begin(), HdStfInterpolations.end(), interpolation) -
                           HdStfInterpolations.begin())]
            .push_back({TfToken(primvar), interpolation, TfToken()});
    };
    name("width", HdInterpolationConstant);
    name("width", HdInterpolationUniform);
    name("width", HdInterpolationVertex);
    name("other", HdInterpolationVarying);
    const auto of = [&descriptors](const char* primvar, HdInterpolation named, size_t values) {
        return HdStfInterpolationOf(descriptors, {TfToken(primvar), named, TfToken()}, values, [](HdInterpolation i) {
            return i == HdInterpolationConstant ? 1u : i == HdInterpolationUniform ? 6u : 8u;
        });
    };
    EXPECT_EQ(of("width", HdInterpolationConstant, 1), HdInterpolationConstant);
    EXPECT_EQ(of("width", HdInterpolationConstant, 6), HdInterpolationUniform);
    EXPECT_EQ(of("width", HdInterpolationConstant, 8), HdInterpolationVertex);
    EXPECT_EQ(of("width", HdInterpolationConstant, 5), HdInterpolationUniform); // one is missing
    EXPECT_EQ(of("width", HdInterpolationConstant, 7), HdInterpolationVertex);  // the same, of either
    EXPECT_EQ(of("width", HdInterpolationConstant, 99), HdInterpolationVertex);
    EXPECT_EQ(of("other", HdInterpolationVarying, 1), HdInterpolationVarying);
    EXPECT_EQ(of("unknown", HdInterpolationFaceVarying, 1), HdInterpolationFaceVarying);
}

TEST(Mesh, NormalsOnlyWithoutSubdivision) {
    const std::string normals =
        "normal3f[] normals = [(0,0,1), (0,0,1), (0,0,1), (0,0,1)] (interpolation = \"vertex\")\n";
    TestHost polygon(testScene(normals + "uniform token subdivisionScheme = \"none\""));
    polygon.execute();
    EXPECT_EQ(polygon.mesh("/Square").mesh->normals.size(), 4u);
    TestHost subdivided(testScene(normals));
    subdivided.execute();
    EXPECT_TRUE(subdivided.mesh("/Square").mesh->normals.empty());
}

TEST(Mesh, RestPoseAndOrientationArrive) {
    TestHost host(testScene(R"(
        point3f[] primvars:stf:rest = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)] (interpolation = "vertex")
        vector3f[] primvars:stf:orientation = [(0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 0, 0)] (
            interpolation = "faceVarying"
        ))"));
    host.execute();
    const auto mesh = host.mesh("/Square").mesh;
    ASSERT_EQ(mesh->rest.size(), 4u);
    EXPECT_EQ(mesh->rest[2], stf::Vec3f(2, 2, 0));
    ASSERT_EQ(mesh->orientation.size(), 4u);
    EXPECT_EQ(mesh->orientationInterpolation, stf::ControlMesh::Interpolation::FaceVarying);
    EXPECT_EQ(mesh->orientation[0], stf::Vec3f(0, 1, 0));

    // A deformer moves the points alone: the rest pose stays.
    const UsdGeomMesh square(host.stage->GetPrimAtPath(SdfPath("/Square")));
    square.GetPointsAttr().Set(VtVec3fArray{{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}});
    host.execute();
    EXPECT_EQ(host.mesh("/Square").mesh->points[0], stf::Vec3f(0, 0, 1));
    EXPECT_EQ(host.mesh("/Square").mesh->rest, mesh->rest);

    const UsdAttribute rest = square.GetPrim().GetAttribute(TfToken("primvars:stf:rest"));
    rest.Set(VtVec3fArray{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}});
    host.execute();
    EXPECT_EQ(host.mesh("/Square").mesh->rest[2], stf::Vec3f(3, 3, 0));
}

TEST(Mesh, RestPoseWithoutInterpolationAndBadOnes) {
    // Whoever forgets the interpolation gets a constant primvar: an array of as many points can mean one thing only.
    TestHost host(testScene(R"(
        point3f[] primvars:stf:rest = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
        vector3f[] primvars:stf:orientation = [(0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 0, 0)])"));
    host.execute();
    EXPECT_EQ(host.mesh("/Square").mesh->rest.size(), 4u);
    EXPECT_EQ(host.mesh("/Square").mesh->orientationInterpolation, stf::ControlMesh::Interpolation::Vertex);

    TestHost wrong(testScene(R"(
        string primvars:stf:rest = "no points" (interpolation = "constant")
        point3f[] primvars:stf:orientation = [(0, 1, 0)] (interpolation = "vertex"))"));
    ASSERT_TRUE(wrong.renderToEnd());
    EXPECT_TRUE(wrong.mesh("/Square").mesh->rest.empty());
    EXPECT_NE(wrong.messages().find("primvars:stf:rest has a type that cannot be used"), std::string::npos);
    EXPECT_NE(wrong.messages().find("stf:orientation ignored (wrong count)"), std::string::npos) << wrong.messages();
}

TEST(Mesh, PropertiesOfTheSchemaArriveInheritedToo) {
    TestHost host(testScene("asset primvars:stf:baseVolume = @/no/such.vdb@ (interpolation = \"constant\")\n"
                            "float primvars:stf:thickness = 0.5 (interpolation = \"constant\")"));
    host.execute();
    ASSERT_TRUE(host.mesh("/Square").stf.has_value());
    EXPECT_EQ(host.mesh("/Square").stf->authoredPath, "/no/such.vdb");
    EXPECT_EQ(host.mesh("/Square").stf->thickness, 0.5f);
    const auto meshVersion = host.mesh("/Square").meshVersion;

    host.stage->GetPrimAtPath(SdfPath("/Square")).GetAttribute(TfToken("primvars:stf:thickness")).Set(0.25f);
    host.execute();
    EXPECT_EQ(host.mesh("/Square").stf->thickness, 0.25f);
    EXPECT_EQ(host.mesh("/Square").meshVersion, meshVersion);
}

TEST(Mesh, NormalsComeAndGoAndChangeTheirInterpolation) {
    TestHost host(testScene("uniform token subdivisionScheme = \"none\""));
    host.execute();
    EXPECT_TRUE(host.mesh("/Square").mesh->normals.empty());
    const UsdGeomMesh square(host.stage->GetPrimAtPath(SdfPath("/Square")));
    const UsdAttribute normals =
        square.GetPrim().CreateAttribute(TfToken("primvars:normals"), SdfValueTypeNames->Normal3fArray);
    normals.SetMetadata(TfToken("interpolation"), TfToken("vertex"));
    normals.Set(VtVec3fArray(4, GfVec3f(0, 1, 0)));
    host.execute();
    EXPECT_EQ(host.mesh("/Square").mesh->normals.size(), 4u);

    normals.SetMetadata(TfToken("interpolation"), TfToken("uniform"));
    normals.Set(VtVec3fArray(1, GfVec3f(1, 0, 0)));
    host.execute();
    if (HDSTF_HAS_PRIM_ORIGINS && !TestHost::byIndices()) {
        GTEST_SKIP() << "scene delegates behind scene indices go on naming the interpolation of before";
    }
    ASSERT_EQ(host.mesh("/Square").mesh->normals.size(), 1u);
    EXPECT_EQ(host.mesh("/Square").mesh->normals[0], stf::Vec3f(1, 0, 0));
    EXPECT_EQ(host.mesh("/Square").mesh->normalInterpolation, stf::ControlMesh::Interpolation::Uniform);

    square.GetPrim().RemoveProperty(TfToken("primvars:normals"));
    host.execute();
    EXPECT_TRUE(host.mesh("/Square").mesh->normals.empty());
}

TEST(Mesh, AnEmptyMeshIsNoObjectUntilItHasFaces) {
    TestHost host(testScene({}, "def Mesh \"Empty\" {}"));
    host.execute();
    EXPECT_EQ(host.delegate->GetScene().meshes().count("/Empty"), 0u);
    const UsdGeomMesh mesh(host.stage->GetPrimAtPath(SdfPath("/Empty")));
    mesh.GetPointsAttr().Set(VtVec3fArray{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
    mesh.GetFaceVertexCountsAttr().Set(VtIntArray{3});
    mesh.GetFaceVertexIndicesAttr().Set(VtIntArray{0, 1, 2});
    host.execute();
    EXPECT_EQ(host.mesh("/Empty").instances.size(), 1u);
}

TEST(Mesh, PurposesThatAreNotAskedForAreNotDrawn) {
    TestHost host(testScene({}, R"(def Mesh "Guide" {
        uniform token purpose = "guide"
        int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    })"));
    host.execute();
    const auto& meshes = host.delegate->GetScene().meshes();
    const auto it = meshes.find("/Guide");
    EXPECT_TRUE(it == meshes.end() || !it->second.visible);
}

// As in Hydra's own lists of prims; Blender's task has no tags.
TEST(Mesh, TasksWithoutRenderTagsDrawAll) {
    TestHost host(testScene());
    host.execute();
    host.setRenderTags({HdRenderTagTokens->guide});
    host.execute();
    EXPECT_FALSE(host.mesh("/Square").visible);
    host.setRenderTags({});
    host.execute();
    EXPECT_TRUE(host.mesh("/Square").visible);
}

} // namespace
