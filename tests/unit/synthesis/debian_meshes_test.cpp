// SPDX-License-Identifier: Apache-2.0
// Targets of synthesis on a scanned mesh of Debian's package libcgal-demo; skipped where it is not installed.

#include "stfLib/acquire/mesh_reader.h"
#include "stfLib/base/temporary_folder.h"
#include "stfLib/synthesis/quality.h"
#include "stfLib/volume/make_samples.h"
#include "tests/unit/synthesis/synthesis_fixture.h"

#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>

using namespace stf;
using namespace stf::test;

namespace {

/// A mesh of the package: unpacked where HDSTF_TEST_MESHES says, else from the archive in its documentation.
std::string meshPath(const std::string& name, const std::string& folder) {
    namespace fs = std::filesystem;
    if (const char* given = std::getenv("HDSTF_TEST_MESHES")) {
        const fs::path path = fs::path(given) / name;
        return fs::exists(path) ? path.string() : "";
    }
    const std::string archive = "/usr/share/doc/libcgal-dev/data.tar.gz";
    if (!fs::exists(archive)) {
        return "";
    }
    const std::string command = "tar xzf " + archive + " -C " + folder + " data/meshes/" + name;
    return std::system(command.c_str()) == 0 ? folder + "/data/meshes/" + name : "";
}

class Bunny : public testing::TestWithParam<const char*> {};

} // namespace

TEST_P(Bunny, MeetsTheTargets) {
    const TemporaryFolder folder;
    const std::string path = meshPath("bunny00.off", folder.path().string());
    if (path.empty()) {
        GTEST_SKIP() << "the meshes of the Debian package libcgal-demo are not there";
    }
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::Loop;
    for (const MeshPart& part : readMeshFile(path)) {
        for (const Vec3d& p : part.mesh.points) {
            mesh.points.push_back(Vec3f(p));
        }
        for (const Vec3i& t : part.mesh.triangles) {
            addFace(mesh, {t.x, t.y, t.z});
        }
    }
    const BaseVolume volume = makeSample(GetParam(), {});
    RefinedSurface surface = refinedOf(mesh);
    // One sample per texel, a hundred thousand.
    const double texel = volume.voxelMm.x;
    const double mmPerUnit = std::sqrt(1e5 * texel * texel / surfaceGraph(surface).totalArea());
    surface = sampleSurface(std::move(surface), texel, mmPerUnit, 1000000, {});
    const Synthesis s = synthesized(surface, volume, 0, mmPerUnit);
    const SynthesisQuality q = measure(s, exemplarMap(s));
    EXPECT_NEAR(q.texelsPerSample, 1, 0.25);
    EXPECT_EQ(q.indexSum, 2); // Euler's characteristic of a sphere
    EXPECT_LT(q.seamRate, 0.05);
    EXPECT_LT(q.neighbourhoodError, 1.5 * q.exemplarError);
    EXPECT_LT(q.reuseMax, 3);
    EXPECT_LT(q.ks, 0.05);
    EXPECT_LT(std::abs(q.deltaR), 0.02);
    EXPECT_EQ(q.foldOvers, 0u);
}

INSTANTIATE_TEST_SUITE_P(Samples, Bunny, testing::Values("marble", "wax"));
