// SPDX-License-Identifier: Apache-2.0
// Light between surfaces: closed forms for boxes, plates and lamps, and both ways between surfaces and shells.
#include "stfLib/render/plain_material.h"
#include "stfLib/render/renderer.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/support/statistics.h"

#include "stfLib/render/preview_bsdf.h"
#include "tests/unit/support/square_mesh.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr int kSize = 8;

PreviewSurface lambert(const Rgb& albedo, const Rgb& emission = Rgb(0.0f)) {
    PreviewSurface s;
    s.diffuseColor = albedo;
    s.emissiveColor = emission;
    s.ior = 1.0f;
    return s;
}

class PlainScene : public ::testing::Test {
protected:
    void SetUp() override {
        settings_.samples = 16;
        scene_.setMetersPerUnit(0.001);
    }

    /// A square about a point with half its edges as vectors; its front is on the side of their cross product.
    void addSquare(const std::string& id, const Vec3f& middle, const Vec3f& x, const Vec3f& y,
                   const PreviewSurface& surface) {
        scene_.setMesh(id, squareMesh(middle, x, y), 0);
        scene_.setInstances(id, {MeshInstance()});
        scene_.setMaterial(id + "/look", surface);
        scene_.setMeshMaterial(id, id + "/look");
    }

    /// A cube of edge 2 `half` about the origin, seen from inside.
    void addBox(float half, const PreviewSurface& surface) {
        const Vec3f axes[3] = {{half, 0, 0}, {0, half, 0}, {0, 0, half}};
        for (int a = 0; a < 3; ++a) {
            const Vec3f &x = axes[(a + 1) % 3], &y = axes[(a + 2) % 3];
            addSquare("/low" + std::to_string(a), -axes[a], x, y, surface);
            addSquare("/high" + std::to_string(a), axes[a], y, x, surface);
        }
    }

    /// A camera at a point that looks towards another through a narrow opening (half its tangent).
    void lookAt(const Vec3d& from, const Vec3d& at, double opening) {
        const Vec3d back = normalize(from - at);
        const Vec3d right = normalize(cross(std::abs(back.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0), back));
        const Vec3d up = cross(back, right);
        const Matrix4 view{right.x, up.x, back.x, 0, right.y,           up.y,           back.y,           0,
                           right.z, up.z, back.z, 0, -dot(right, from), -dot(up, from), -dot(back, from), 1};
        const double nearest = 0.001, farthest = 1000, depth = farthest - nearest;
        const Matrix4 projection{1 / opening,
                                 0,
                                 0,
                                 0,
                                 0,
                                 1 / opening,
                                 0,
                                 0,
                                 0,
                                 0,
                                 -(farthest + nearest) / depth,
                                 -1,
                                 0,
                                 0,
                                 -2 * farthest * nearest / depth,
                                 0};
        camera_ = Camera(view, projection);
    }

    /// Pixels of an AOV of the green channel.
    std::vector<double> green(Aov aov = Aov::Color) {
        renderer_.setMessages([this](Severity severity, const std::string& text) {
            messages_ += severity == Severity::Error ? text + "\n" : "";
        });
        renderer_.setSettings(settings_);
        renderer_.setCamera(camera_, kSize, kSize);
        Progress progress;
        renderer_.prepare(scene_, progress);
        renderer_.restart();
        while (!renderer_.converged()) {
            renderer_.renderPass(progress);
        }
        const std::vector<float> image = renderer_.film().read(aov);
        const std::size_t channels = image.size() / (kSize * kSize);
        std::vector<double> pixels;
        for (std::size_t i = 0; i < image.size(); i += channels) {
            pixels.push_back(double(image[i + (channels > 1 ? 1 : 0)]));
        }
        return pixels;
    }
    /// Mean of the image: pixels are samples of nearly the same.
    Estimate mean(Aov aov = Aov::Color) { return estimate(green(aov)); }

    void addDistant(const Vec3d& towards, float irradiance, bool shadows = true) {
        Light l;
        const Vec3d z = normalize(towards);
        Vec3d x, y;
        orthonormalBasis(z, x, y);
        l.lightToWorld.x = x;
        l.lightToWorld.y = y;
        l.lightToWorld.z = z;
        l.emission = Rgb(irradiance);
        l.shadows = shadows;
        scene_.setLight("/light", l);
    }

    /// Gives a mesh a shell of uniform material around a core, black or of marble.
    void giveShell(const std::string& id, bool core = false) {
        SampleOptions o;
        o.size = {1, 1, 8};
        o.voxelMm = 0.5;
        const std::string file = (folder_.path() / "uniform.vdb").string();
        writeBaseVolume(makeSample("uniform", o), file);
        StfBinding binding;
        binding.baseVolume = file;
        binding.quality = 0.1f;
        binding.coreModel = core ? "dipole" : "none";
        binding.thickness = core ? 0.5f : 0.0f;
        binding.coreSigmaA = Rgb(0.1f);
        binding.coreSigmaSPrime = Rgb(4.0f);
        scene_.setStf(id, binding);
    }

    Scene scene_;
    Camera camera_;
    Renderer renderer_;
    RenderSettings settings_;
    std::string messages_;
    TemporaryFolder folder_;
};

// From a point to a square of half edge `x` opposite of it at distance 1.
double formFactor(double x) {
    const double r = std::sqrt(1 + x * x);
    return 4 / kPi * (x / r) * std::atan(x / r);
}

// Every wall has albedo a and shines with E: after n bounces and the direct light of the walls themselves, light is
// E (1 - a^(n+2)) / (1 - a), everywhere.
TEST_F(PlainScene, ClosedBoxIsAFurnace) {
    lookAt({0.2, 0.1, 0}, {1, 0.3, -0.2}, 0.7);
    for (const double a : {0.3, 0.8}) {
        addBox(1, lambert(Rgb(float(a)), Rgb(0.5f)));
        for (const int depth : {0, 1, 4, 60}) {
            settings_.maxDepth = depth;
            settings_.samples = depth > 4 ? 256 : 16;
            EXPECT_TRUE(agrees(mean(), 0.5 * (1 - std::pow(a, depth + 2)) / (1 - a), 0.02, 1e-5)) << a << " " << depth;
        }
    }
    EXPECT_EQ(messages_, "");
}

// A red plate that is lit from behind the white one sends light onto it: its radiance times the form factor.
TEST_F(PlainScene, ColourBleedsByTheFormFactor) {
    addSquare("/white", {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, lambert(Rgb(0.6f)));
    addSquare("/red", {0, 0, 1}, {0, 0.8f, 0}, {0.8f, 0, 0}, lambert({0.9f, 0.5f, 0.1f}));
    addDistant({0, 0, -1}, 2, false);
    lookAt({0, 0, 0.5}, {0, 0, 0}, 0.02);
    settings_.samples = 64;
    settings_.maxDepth = 1;
    const double once = 0.6 * formFactor(0.8) * 0.5 * 2 / kPi;
    EXPECT_TRUE(agrees(mean(), once, 0.02, 1e-4 * once));
    settings_.maxDepth = 0;
    EXPECT_EQ(mean().mean, 0);
    settings_.maxDepth = 8;
    EXPECT_GT(mean().mean, 1.05 * once) << "light goes to and fro";
}

// Light that a glossy surface takes from a lamp: found by its own rays and by samples of the lamp, and by quadrature.
TEST_F(PlainScene, GlossyHighlightsAgreeWithQuadrature) {
    Light lamp;
    lamp.type = Light::Type::Rect;
    lamp.width = 1;
    lamp.height = 0.6f;
    lamp.emission = Rgb(3.0f);
    lamp.lightToWorld.translation = {-0.8, 0, 1};
    scene_.setLight("/lamp", lamp);
    lookAt({0.9, 0, 1.1}, {0, 0, 0}, 1e-4);
    const Vec3f out = normalize(Vec3f(0.9f, 0, 1.1f));
    for (const float roughness : {0.15f, 0.4f, 0.8f}) {
        PreviewSurface s;
        s.diffuseColor = Rgb(0.4f);
        s.roughness = roughness;
        s.clearcoat = 0.5f;
        s.clearcoatRoughness = 0.2f;
        addSquare("/plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, s);
        TextureStore none;
        const PreviewBsdf bsdf(PlainMaterial("/m", s, none, {}).at({}, Rgb(0.0f)));
        constexpr int n = 600;
        double expected = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                const Vec3f to(float(-0.8 + (i + 0.5) / n - 0.5), float(0.6 * ((j + 0.5) / n - 0.5)), 1);
                const double square = double(dot(to, to)), cosine = 1 / std::sqrt(square);
                expected += double(bsdf.evaluate(out, normalize(to)).y) * 3 * cosine * cosine / square;
            }
        }
        expected *= 0.6 / (double(n) * n);
        settings_.samples = 256;
        for (const int depth : {0, 4}) {
            settings_.maxDepth = depth;
            EXPECT_TRUE(agrees(mean(), expected, 0.01, 2e-3 * expected)) << roughness << " " << depth;
        }
    }
}

// The same under a dome: the albedo of the surface, whatever finds the light.
TEST_F(PlainScene, WhiteMetalUnderADomeShowsItsAlbedo) {
    Light dome;
    dome.type = Light::Type::Dome;
    dome.emission = Rgb(1.0f);
    scene_.setLight("/dome", dome);
    lookAt({0.6, 0, 0.8}, {0, 0, 0}, 1e-4);
    PreviewSurface s;
    s.diffuseColor = Rgb(1.0f);
    s.metallic = 1.0f;
    for (const float roughness : {0.0f, 1.0f}) {
        s.roughness = roughness;
        addSquare("/plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, s);
        const double mu = 0.8, exact = roughness > 0 ? 1 - mu * std::log(1 + 1 / mu) : 1;
        settings_.samples = 256;
        EXPECT_TRUE(agrees(mean(), exact, 0.01, 1e-3)) << roughness;
    }
}

TEST_F(PlainScene, ClearSurfacesLetLightAndSightPass) {
    addSquare("/floor", {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, lambert(Rgb(0.5f)));
    addDistant({0, 0, 1}, float(kPi));
    PreviewSurface veil = lambert(Rgb(0.8f));
    veil.opacity = 0.25f;
    addSquare("/veil", {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, veil);
    settings_.maxDepth = 0;
    settings_.samples = 256;
    lookAt({0.01, 0, 0.5}, {0, 0, 0}, 0.01);
    EXPECT_NEAR(mean().mean, 0.75 * 0.5, 1e-5) << "its shadow";
    lookAt({0.01, 0, 2}, {0, 0, 0}, 0.01);
    EXPECT_TRUE(agrees(mean(), 0.25 * 0.8 + 0.75 * 0.75 * 0.5, 0.01, 1e-6)) << "light passes twice";
    veil.opacityThreshold = 0.5f;
    addSquare("/veil", {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, veil);
    EXPECT_NEAR(mean().mean, 0.5, 1e-5) << "a hole";
    EXPECT_NEAR(estimate(green(Aov::Position)).mean, 0, 1e-4) << "through which the floor is picked";
    veil.opacity = 0.5f;
    addSquare("/veil", {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, veil);
    EXPECT_NEAR(mean().mean, 0.8, 1e-5) << "whole";
    lookAt({0.01, 0, 0.5}, {0, 0, 0}, 0.01);
    EXPECT_EQ(mean().mean, 0);
}

// A shining square of a mesh is the rectangle light of its place and radiance, and the closed form of a parallel square
// over Lambert's floor: by samples of it, by rays that meet it, and by both together.
TEST_F(PlainScene, AShiningMeshIsALight) {
    settings_.samples = 256;
    lookAt({1.5, 0, 1}, {0, 0, 0}, 0.002);
    const double s = 0.5 / std::sqrt(1.25), corner = 2 * s * std::atan(s) / (2 * kPi);
    const double lambertian = 0.6 * 2 * 4 * corner; // albedo times radiance times the form factor of four corners
    PreviewSurface glossy = lambert(Rgb(0.0f));
    glossy.metallic = 1.0f;
    glossy.diffuseColor = Rgb(0.6f);
    glossy.roughness = 0.6f;
    for (int depth : {0, 3}) {
        settings_.maxDepth = depth;
        for (const PreviewSurface& look : {lambert(Rgb(0.6f)), glossy}) {
            addSquare("/floor", {0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, look);
            // Two halves of different triangles, the light's area is not its number of triangles.
            addSquare("/lamp", {0, 0, 1}, {0.5f, 0, 0}, {0, 0.5f, 0}, lambert(Rgb(0.0f), Rgb(2.0f)));
            const Estimate mesh = mean();
            scene_.removeMesh("/lamp");
            Light l;
            l.type = Light::Type::Rect;
            l.lightToWorld.translation = {0, 0, 1};
            l.emission = Rgb(2.0f);
            scene_.setLight("/rect", l);
            const Estimate light = mean();
            scene_.removeLight("/rect");
            EXPECT_LT(mesh.sigma, 0.01 * mesh.mean);
            EXPECT_NEAR(mesh.mean, light.mean, 4 * std::hypot(mesh.sigma, light.sigma)) << "depth " << depth;
            if (look == lambert(Rgb(0.6f))) {
                EXPECT_TRUE(agrees(mesh, lambertian));
            }
        }
    }
    EXPECT_EQ(messages_, "");
}

TEST_F(PlainScene, ClampLimitsWhatBouncesBring) {
    PreviewSurface wall = lambert(Rgb(0.5f), Rgb(1.0f));
    wall.opacity = 0.99999f; // not opaque: shines on those it meets, but is no light of its own
    addBox(1, wall);
    lookAt({0, 0, 0}, {1, 0.3, -0.2}, 0.7);
    settings_.maxDepth = 1;
    EXPECT_NEAR(mean().mean, 1.5, 1e-3);
    settings_.indirectClamp = 0.2f;
    EXPECT_NEAR(mean().mean, 1.2, 1e-3);
}

// Walls that shine like a dome light a shell as the dome does.
TEST_F(PlainScene, ShellTakesLightOfSurfaces) {
    addSquare("/shell", {0, 0, 0}, {10, 0, 0}, {0, 10, 0}, lambert(Rgb(0.5f)));
    giveShell("/shell");
    lookAt({0, 2, 20}, {0, 0, 0}, 0.1);
    settings_.samples = 512;
    Light dome;
    dome.type = Light::Type::Dome;
    dome.emission = Rgb(1.0f);
    scene_.setLight("/dome", dome);
    const Estimate byDome = mean();
    scene_.removeLight("/dome");
    addBox(40, lambert(Rgb(0.0f), Rgb(1.0f)));
    const Estimate byWalls = mean();
    EXPECT_EQ(messages_, "");
    EXPECT_GT(byDome.mean, 0.1);
    EXPECT_TRUE(agrees(byWalls, byDome.mean, 0.01, 4 * byDome.sigma));
    settings_.maxDepth = 0; // no bounces: samples of the walls as lights alone
    EXPECT_TRUE(agrees(mean(), byDome.mean, 0.01, 4 * byDome.sigma));
}

// A plate beside a lit shell shows the shell's radiance times the form factor.
TEST_F(PlainScene, ShellLightsSurfaces) {
    addSquare("/plate", {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, lambert(Rgb(0.5f)));
    addSquare("/shell", {0, 0, 20}, {0, 4, 0}, {4, 0, 0}, lambert(Rgb(0.5f)));
    giveShell("/shell");
    addDistant({0, 0, -1}, 3, false);
    settings_.samples = 256;
    settings_.maxDepth = 1;
    lookAt({0, 0, 1}, {0, 0, 20}, 0.1);
    const Estimate shell = mean();
    lookAt({0, 0, 1}, {0, 0, 0}, 0.1);
    const Estimate plate = mean();
    EXPECT_GT(shell.mean, 0.1);
    EXPECT_TRUE(agrees(plate, 0.5 * formFactor(0.2) * shell.mean, 0.03, 0.03 * plate.mean));
}

} // namespace
// Walls that shine all around are a dome, for the core as well.
TEST_F(PlainScene, CoresTakeLightOfSurfaces) {
    addSquare("/shell", {0, 0, 0}, {0.3f, 0, 0}, {0, 0.3f, 0}, lambert(Rgb(0.5f)));
    giveShell("/shell", true);
    lookAt({0, 0, 0.5}, {0, 0, 0}, 0.02);
    settings_.samples = 32;
    Light dome;
    dome.type = Light::Type::Dome;
    dome.emission = Rgb(1.0f);
    scene_.setLight("/dome", dome);
    const double byDome = mean(Aov::StfCore).mean;
    EXPECT_GT(byDome, 0.05);
    scene_.removeLight("/dome");
    // Meshes that shine are lights of their own; what they reflect comes by bounces alone.
    addBox(1, lambert(Rgb(0.5f), Rgb(0.5f)));
    EXPECT_NEAR(mean(Aov::StfCore).mean / byDome, 0.5 * (2 - std::pow(0.5, 4)), 0.04);
    settings_.maxDepth = 0;
    EXPECT_NEAR(mean(Aov::StfCore).mean / byDome, 0.5, 0.025) << "the core is solved again, without bounces";
}

TEST_F(PlainScene, CoresAreLitThroughHoles) {
    addSquare("/shell", {0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}, lambert(Rgb(0.5f)));
    giveShell("/shell", true);
    addDistant({0, 0, 1}, 2);
    lookAt({0, 0, 0.5}, {0, 0, 0}, 0.02);
    settings_.maxDepth = 0;
    const double open = mean(Aov::StfCore).mean;
    EXPECT_GT(open, 0.02);
    PreviewSurface veil = lambert(Rgb(0.5f));
    veil.opacityIsPresence = true;
    for (const float opacity : {0.0f, 0.25f, 1.0f}) {
        veil.opacity = opacity;
        addSquare("/veil", {0, 0, 0.8f}, {2, 0, 0}, {0, 2, 0}, veil);
        EXPECT_NEAR(mean(Aov::StfCore).mean, (1 - double(opacity)) * open, 0.01 * open) << opacity;
    }
}

} // namespace stf::test
