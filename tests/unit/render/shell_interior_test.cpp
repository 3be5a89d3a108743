// SPDX-License-Identifier: Apache-2.0
// What lies in a shell and what is seen from inside one, against closed forms: plates that glow and absorb.
#include "stfLib/render/renderer.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr double kExtinction = 0.7, kGlow = 0.3, kDepth = 2; // 1/mm, radiance per mm, mm

/// What a way of `mm` through the plate glows with.
double glow(double mm) {
    return kGlow / kExtinction * -std::expm1(-kExtinction * mm);
}
double left(double mm) {
    return std::exp(-kExtinction * mm);
}

class ShellInterior : public ::testing::Test {
protected:
    void SetUp() override {
        settings_.samples = 64;
        settings_.maxDepth = 0;
        folder_ = std::filesystem::temp_directory_path() /
                  (std::string("stf_interior_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::create_directories(folder_);
        scene_.setMetersPerUnit(0.001);
        volume_ = write(1);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string write(float ior) {
        SampleOptions o;
        o.size = {1, 1, int(kDepth * 10)};
        o.voxelMm = 0.1;
        o.extinction = Rgb(float(kExtinction));
        o.albedo = Rgb(0.0f);
        BaseVolume v = makeSample("uniform", o);
        v.emission.assign(v.voxelCount(), Rgb(float(kGlow)));
        if (ior != 1) {
            v.ior.assign(v.voxelCount(), ior);
        }
        const std::string path = (folder_ / ("plate" + std::to_string(ior) + ".vdb")).string();
        writeBaseVolume(v, path);
        return path;
    }

    /// A square of edge 20 mm that faces +z, its top at a height; a glowing surface, or a plate where a volume is
    /// given.
    void addSquare(const std::string& id, float height, float radiance, const std::string& volume = "") {
        ControlMesh m;
        m.scheme = ControlMesh::Scheme::None;
        m.points = {{-10, -10, height}, {10, -10, height}, {10, 10, height}, {-10, 10, height}};
        m.faceVertexCounts = {4};
        m.faceVertexIndices = {0, 1, 2, 3};
        m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        m.uvIndices = {0, 1, 2, 3};
        scene_.setMesh(id, m, 0);
        squares_.push_back(id);
        if (volume.empty()) {
            PreviewSurface s;
            s.diffuseColor = Rgb(0.0f);
            s.emissiveColor = Rgb(radiance);
            s.ior = 1.0f;
            scene_.setMaterial(id + "/look", s);
            scene_.setMeshMaterial(id, id + "/look");
            return;
        }
        StfBinding binding;
        binding.baseVolume = volume;
        binding.quality = 0.1f;
        scene_.setStf(id, binding);
    }

    /// Mean radiance seen straight down (or up) from a height, all of the scene moved by a map.
    double seen(double height, bool up = false, const Transform& map = {}) {
        for (const std::string& id : squares_) {
            MeshInstance instance;
            instance.objectToWorld = map;
            scene_.setInstances(id, {instance});
        }
        Renderer renderer;
        renderer.setSettings(settings_);
        const double way = up ? -1 : 1, reach = 50;
        // Rows: right, up and back of the camera as columns.
        const Matrix4 view{1, 0, 0, 0, 0, way, 0, 0, 0, 0, way, 0, 0, 0, -height * way, 1};
        const Matrix4 projection{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -2 / reach, 0, 0, 0, -1, 1};
        const Transform back = map.inverse();
        const Vec3d rows[4] = {back.x, back.y, back.z, back.translation};
        Matrix4 moved{};
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t k = 0; k < 4; ++k) {
                moved[4 * i + k] = rows[i].x * view[k] + rows[i].y * view[4 + k] + rows[i].z * view[8 + k] +
                                   (i == 3 ? view[12 + k] : 0.0);
            }
        }
        renderer.setCamera(Camera(moved, projection), 4, 4);
        renderer.setClearColor(Rgb(float(kBackdrop)), 1);
        Progress progress;
        renderer.prepare(scene_, progress);
        renderer.restart();
        while (!renderer.converged()) {
            renderer.renderPass(progress);
        }
        const std::vector<float> image = renderer.film().read(Aov::Color);
        double sum = 0, alpha = 0;
        for (std::size_t i = 0; i < image.size(); i += 4) {
            sum += double(image[i]) / 16;
            alpha += double(image[i + 3]) / 16;
        }
        EXPECT_NEAR(alpha, 1, 0.02); // where a surface mirrors, one of both ways is taken at random
        return sum;
    }

    static constexpr double kBackdrop = 0.4;
    RenderSettings settings_;
    Scene scene_;
    std::vector<std::string> squares_;
    std::filesystem::path folder_;
    std::string volume_;
};

TEST_F(ShellInterior, ASurfaceInsideIsSeenThroughWhatLiesBeforeIt) {
    addSquare("/plate", 0, 0, volume_);
    addSquare("/lamp", -0.75f, 2);
    EXPECT_NEAR(seen(10), glow(0.75) + 2 * left(0.75), 2e-3);
}

TEST_F(ShellInterior, ASurfaceBehindTheCoresBoundaryIsHidden) {
    addSquare("/plate", 0, 0, volume_);
    addSquare("/lamp", -2.5f, 2);
    EXPECT_NEAR(seen(10), glow(kDepth), 2e-3);
}

TEST_F(ShellInterior, RefractionLeavesWhatIsSeenStraightDownButFresnelAndTheSolidAngle) {
    addSquare("/plate", 0, 0, write(1.5f));
    addSquare("/lamp", -0.75f, 2);
    const double r = 0.04; // ((1.5 - 1) / (1.5 + 1))^2, of the backdrop nothing is mirrored
    EXPECT_NEAR(seen(10), (1 - r) / 2.25 * (glow(0.75) + 2 * left(0.75)), 0.02);
}

TEST_F(ShellInterior, OverlappingPlatesCountOnce) {
    addSquare("/first", 0, 0, volume_);
    addSquare("/second", -1.25f, 0, volume_);
    EXPECT_NEAR(seen(10), glow(1.25 + kDepth), 3e-3);
}

TEST_F(ShellInterior, ACameraInAShellSeesWhatLiesBeforeIt) {
    addSquare("/plate", 0, 0, volume_);
    EXPECT_NEAR(seen(-0.6), glow(kDepth - 0.6), 2e-3);
    EXPECT_NEAR(seen(-0.6, true), glow(0.6) + kBackdrop * left(0.6), 2e-3);
}

TEST_F(ShellInterior, ACameraThatGoesIntoAShellMeetsNoJump) {
    addSquare("/plate", 0, 0, volume_);
    const double full = glow(kDepth);
    for (const double height : {1e-3, 1e-5, 1e-7, 0.0, -1e-7, -1e-5, -1e-3}) {
        EXPECT_NEAR(seen(height), full, 3e-3) << height;
    }
}

TEST_F(ShellInterior, ALampInAShellIsSeenFromInsideToo) {
    addSquare("/plate", 0, 0, volume_);
    addSquare("/lamp", -1.5f, 2);
    EXPECT_NEAR(seen(-0.5), glow(1) + 2 * left(1), 2e-3);
}

// Optics happen in object space: whatever map an instance has, the same object's ray sees the same.
TEST_F(ShellInterior, AnyTransformShowsTheSame) {
    struct Case {
        const char* name;
        Transform map;
    };
    const double c = std::cos(0.7), s = std::sin(0.7);
    const Transform turned{{c, s, 0}, {-s, 0.6 * c, 0.8}, {0.3, -0.4, 0.9}, {1, 2, 3}}; // and sheared
    const auto scaled = [](double x, double y, double z) { return Transform{{x, 0, 0}, {0, y, 0}, {0, 0, z}, {}}; };
    Transform far = turned, tinyFar = scaled(0.1, 0.1, 0.1);
    far.translation = {1e6, -2e6, 5e5};
    tinyFar.translation = {1e6, 1e6, 1e6};
    addSquare("/plate", 0, 0, volume_);
    addSquare("/lamp", -0.75f, 2);
    for (const Case& i : {Case{"turned, sheared", turned}, Case{"mirrored", scaled(-1, 1, 1)},
                          Case{"mirrored through the plate", scaled(1, 1, -1)}, Case{"flat", scaled(3, 1, 0.01)},
                          Case{"tall", scaled(0.2, 1, 300)}, Case{"1e-6", scaled(1e-6, 1e-6, 1e-6)},
                          Case{"1e6", scaled(1e6, 1e6, 1e6)}, Case{"far", far}, Case{"small and far", tinyFar}}) {
        EXPECT_NEAR(seen(10, false, i.map), glow(0.75) + 2 * left(0.75), 2e-3) << i.name;
        EXPECT_NEAR(seen(-0.5, false, i.map), glow(0.25) + 2 * left(0.25), 2e-3) << i.name << ", from inside";
    }
}

} // namespace
} // namespace stf::test
