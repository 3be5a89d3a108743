// SPDX-License-Identifier: Apache-2.0
// AOVs of the first hit on a plate whose relief is a slope: a plane, of which everything is known.
#include "stfLib/render/renderer.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr int kPixels = 8;
constexpr double kVoxel = 0.25, kDepth = 4, kTile = 8; // mm

/// Depth of the relief: a gable along x, periodic with the tile.
double reliefAt(double x) {
    const double t = x - kTile * std::floor(x / kTile);
    return 0.55 + 0.4 * std::abs(t - 0.5 * kTile) / kTile * 2;
}
constexpr double kSlope = 0.8 / kTile;

class FirstHit : public ::testing::TestWithParam<float> {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / "stf_first_hit";
        std::filesystem::create_directories(folder_);
        SampleOptions o;
        o.size = {int(kTile / kVoxel), int(kTile / kVoxel), int(kDepth / kVoxel)};
        o.voxelMm = kVoxel;
        o.extinction = Rgb(1.0f);
        BaseVolume v = makeSample("uniform", o);
        v.surface.resize(v.voxelCount());
        v.ior.assign(v.voxelCount(), GetParam());
        for (int z = 0; z < v.size.z; ++z) {
            for (int y = 0; y < v.size.y; ++y) {
                for (int x = 0; x < v.size.x; ++x) {
                    const std::size_t i = v.index(x, y, z);
                    const double above = reliefAt((x + 0.5) * kVoxel) - (z + 0.5) * kVoxel;
                    v.surface[i] = float(above / std::sqrt(1 + kSlope * kSlope));
                    v.albedo[i] = Rgb(z * kVoxel < 1.5 ? 0.25f : 0.75f);
                    if (above > kVoxel) {
                        v.extinction[i] = Rgb(0.0f);
                    }
                }
            }
        }
        const std::string path = (folder_ / ("gable" + std::to_string(GetParam()) + ".vdb")).string();
        writeBaseVolume(v, path);
        ControlMesh m;
        m.scheme = ControlMesh::Scheme::None;
        const float w = 4 * float(kTile);
        m.points = {{0, 0, 0}, {w, 0, 0}, {w, w, 0}, {0, w, 0}, {w, -w, 0}, {0, -w, 0}};
        m.faceVertexCounts = {4, 4};
        m.faceVertexIndices = {5, 4, 1, 0, 0, 1, 2, 3};
        m.uvs = {{0, -4}, {4, -4}, {4, 0}, {0, 0}, {0, 0}, {4, 0}, {4, 4}, {0, 4}};
        m.uvIndices = {0, 1, 2, 3, 4, 5, 6, 7};
        scene_.setMetersPerUnit(0.001);
        scene_.setMesh("/gable", m, 0);
        scene_.setInstances("/gable", {MeshInstance()});
        StfBinding binding;
        binding.baseVolume = path;
        binding.quality = 0.5f;
        scene_.setStf("/gable", binding);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    /// A parallel camera straight above, about a point, 4 mm wide.
    void render(double x, double y) {
        const Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -20, 1};
        const Matrix4 projection{0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, -2.0 / 50, 0, 0, 0, -1, 1};
        RenderSettings settings;
        settings.samples = 1;
        renderer_.setSettings(settings);
        renderer_.setCamera(Camera(view, projection), kPixels, kPixels);
        Progress progress;
        renderer_.prepare(scene_, progress);
        renderer_.restart();
        renderer_.renderPass(progress);
    }

    std::filesystem::path folder_;
    Scene scene_;
    Renderer renderer_;
};

TEST_P(FirstHit, DescribesTheReliefThatIsSeen) {
    const double x = 14, y = 10; // on the falling side of a gable
    render(x, y);
    const std::vector<float> position = renderer_.film().read(Aov::Position),
                             normal = renderer_.film().read(Aov::Normal),
                             depth = renderer_.film().read(Aov::CameraDepth),
                             albedo = renderer_.film().read(Aov::Albedo);
    const std::vector<std::int32_t> face = renderer_.film().readIds(Aov::ElementId);
    for (std::size_t i = 0; i < std::size_t(kPixels * kPixels); ++i) {
        const float* p = position.data() + 3 * i;
        EXPECT_NEAR(p[0], x + (double(i % kPixels) + 0.5) * 0.5 - 2, 1e-3);
        // A tenth of a voxel: the field is interpolated, the grid is not exact.
        EXPECT_NEAR(p[2], -reliefAt(double(p[0])), 0.1 * kVoxel);
        EXPECT_NEAR(depth[i], 20 - double(p[2]), 1e-3);
        const Vec3f n(normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]);
        EXPECT_GT(dot(n, normalize(Vec3f(float(kSlope), 0, 1))), 0.999f) << n.x << ' ' << n.z;
        EXPECT_FLOAT_EQ(albedo[3 * i], 0.25f);
        EXPECT_EQ(face[i], 1);
    }
}

TEST_P(FirstHit, NamesTheAuthoredFace) {
    render(10, -10);
    for (const std::int32_t face : renderer_.film().readIds(Aov::ElementId)) {
        EXPECT_EQ(face, 0);
    }
}

INSTANTIATE_TEST_SUITE_P(, FirstHit, ::testing::Values(1.0f, 1.4f));

} // namespace
} // namespace stf::test
