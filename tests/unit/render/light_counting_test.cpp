// SPDX-License-Identifier: Apache-2.0
// Light that both samples of lights and rays of paths may find counts once, whatever lies between, and no path finds
// much of it at once.
#include "stfLib/render/plain_material.h"
#include "stfLib/render/preview_bsdf.h"
#include "stfLib/render/renderer.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/support/statistics.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979;
constexpr double kExtinction = 0.7; // 1/mm, of what absorbs
constexpr double kEdge = 5;         // mm, half that of the cube

PreviewSurface metal(float roughness) {
    PreviewSurface s;
    s.diffuseColor = Rgb(1.0f);
    s.metallic = 1.0f;
    s.roughness = roughness;
    return s;
}
PreviewSurface lambert(float albedo) {
    PreviewSurface s;
    s.diffuseColor = Rgb(albedo);
    s.ior = 1.0f;
    return s;
}

class LightCounting : public ::testing::Test {
protected:
    void SetUp() override {
        scene_.setMetersPerUnit(0.001);
        settings_.samples = 256;
    }

    void addMesh(const std::string& id, const ControlMesh& m) {
        scene_.setMesh(id, m, 0);
        scene_.setInstances(id, {MeshInstance()});
    }
    /// A square about a point with half its edges as vectors.
    void addSquare(const std::string& id, const Vec3f& middle, const Vec3f& x, const Vec3f& y) {
        ControlMesh m;
        m.scheme = ControlMesh::Scheme::None;
        m.points = {middle - x - y, middle + x - y, middle + x + y, middle - x + y};
        m.faceVertexCounts = {4};
        m.faceVertexIndices = {0, 1, 2, 3};
        m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        m.uvIndices = {0, 1, 2, 3};
        addMesh(id, m);
    }
    void look(const std::string& id, const PreviewSurface& s) {
        scene_.setMaterial(id + "/look", s);
        scene_.setMeshMaterial(id, id + "/look");
    }
    /// A shell of 2 mm that absorbs.
    void giveShell(const std::string& id, float ior = 1) {
        SampleOptions o;
        o.size = {1, 1, 20};
        o.voxelMm = 0.1;
        o.extinction = Rgb(float(kExtinction));
        o.albedo = Rgb(0.0f);
        BaseVolume v = makeSample("uniform", o);
        if (ior != 1) {
            v.ior.assign(v.voxelCount(), ior);
        }
        const std::string file = (folder_.path() / ("absorbing" + std::to_string(ior) + ".vdb")).string();
        writeBaseVolume(v, file);
        StfBinding binding;
        binding.baseVolume = file;
        binding.quality = 0.1f;
        scene_.setStf(id, binding);
    }
    /// A cube with such a shell, and a wall behind one of its edges, across the light that comes from (-1, -1, 0):
    /// light gets to its middle on a way of sqrt 2 mm through the edge.
    void addCubeBeforeWall(float ior) {
        ControlMesh m;
        m.scheme = ControlMesh::Scheme::None;
        for (int i = 0; i < 8; ++i) {
            const auto at = [&](int bit) { return float(i >> bit & 1 ? kEdge : -kEdge); };
            m.points.push_back({at(0), at(1), at(2)});
        }
        m.faceVertexCounts = {4, 4, 4, 4, 4, 4};
        m.faceVertexIndices = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
        m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        for (int f = 0; f < 6; ++f) {
            m.uvIndices.insert(m.uvIndices.end(), {0, 1, 2, 3});
        }
        addMesh("/cube", m);
        giveShell("/cube", ior);
        const float r = std::sqrt(0.5f);
        const Vec3f on = wallMiddle();
        addSquare("/wall", on, Vec3f(0, 0, 2), Vec3f(2 * r, -2 * r, 0));
        const Vec3d from = Vec3d(on) + Vec3d(-1.4, -1.4, 1.5);
        lookAt(from, Vec3d(on), 1e-3);
    }
    static Vec3f wallMiddle() { return Vec3f(4.5f, -4.5f, 0) + Vec3f(4.2f, 4.2f, 0); }

    void addSun(double halfDegrees) {
        Light l;
        const Vec3d z = normalize(Vec3d(-1, -1, 0));
        Vec3d x, y;
        orthonormalBasis(z, x, y);
        l.lightToWorld.x = x;
        l.lightToWorld.y = y;
        l.lightToWorld.z = z;
        l.emission = Rgb(float(kPi));
        l.normalize = true;
        l.angle = float(2 * halfDegrees);
        scene_.setLight("/sun", l);
    }
    void addLamp() { // radiance 3, shines downwards
        Light lamp;
        lamp.type = Light::Type::Rect;
        lamp.width = lamp.height = 1;
        lamp.emission = Rgb(3.0f);
        lamp.lightToWorld.translation = {-0.8, 0, 1};
        scene_.setLight("/lamp", lamp);
    }

    void lookAt(const Vec3d& from, const Vec3d& at, double opening) {
        const Vec3d back = normalize(from - at);
        const Vec3d right = normalize(cross(std::abs(back.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0), back));
        const Vec3d up = cross(back, right);
        const Matrix4 view{right.x, up.x, back.x, 0, right.y,           up.y,           back.y,           0,
                           right.z, up.z, back.z, 0, -dot(right, from), -dot(up, from), -dot(back, from), 1};
        const double o = 1 / opening;
        camera_ = Camera(view, {o, 0, 0, 0, 0, o, 0, 0, 0, 0, -1.001, -1, 0, 0, -0.1, 0});
    }
    /// Pixels of the colour's green channel.
    std::vector<double> pixels(int size = 8) {
        Renderer renderer;
        std::string messages;
        renderer.setMessages([&](Severity s, const std::string& text) {
            messages += s == Severity::Error ? text + "\n" : std::string();
        });
        renderer.setSettings(settings_);
        renderer.setCamera(camera_, size, size);
        Progress progress;
        renderer.prepare(scene_, progress);
        renderer.restart();
        while (!renderer.converged()) {
            renderer.renderPass(progress);
        }
        EXPECT_EQ(messages, "");
        const std::vector<float> image = renderer.film().read(Aov::Color);
        std::vector<double> out;
        for (std::size_t i = 0; i < image.size(); i += 4) {
            out.push_back(double(image[i + 1]));
        }
        return out;
    }
    Estimate mean() { return estimate(pixels()); }

    Scene scene_;
    Camera camera_;
    RenderSettings settings_;
    TemporaryFolder folder_;
};

// Length of a ray in the cube.
double wayThroughCube(const Vec3d& o, const Vec3d& d) {
    double near = 0, far = 1e9;
    for (int a = 0; a < 3; ++a) {
        const double p = (-kEdge - o[a]) / d[a], q = (kEdge - o[a]) / d[a];
        near = std::max(near, std::min(p, q));
        far = std::min(far, std::max(p, q));
    }
    return std::max(0.0, far - near);
}

/// Mean of f over a sun's disc of a half angle about (-1, -1, 0), by its projected solid angle.
template<class F>
double overSun(double halfDegrees, F f) {
    const Vec3d z = normalize(Vec3d(-1, -1, 0));
    Vec3d x, y;
    orthonormalBasis(z, x, y);
    constexpr int n = 200;
    const double most = std::sin(halfDegrees * kPi / 180);
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const double r = most * std::sqrt((i + 0.5) / n), phi = 2 * kPi * (j + 0.5) / n;
            sum += f(normalize(x * (r * std::cos(phi)) + y * (r * std::sin(phi)) + z * std::sqrt(1 - r * r)));
        }
    }
    return sum / (n * n);
}

TEST_F(LightCounting, ALampBeforeAHoleIsMirroredOnce) {
    addSquare("/plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    look("/plate", metal(0));
    addLamp();
    lookAt({0.8, 0, 1}, {0, 0, 0}, 1e-3);
    PreviewSurface hole = lambert(0.5f);
    hole.opacity = 0;
    hole.opacityThreshold = 0.5f;
    addSquare("/hole", {-1.6f, 0, 2}, {1, 0, 0}, {0, 1, 0});
    look("/hole", hole);
    for (const int depth : {0, 3}) {
        settings_.maxDepth = depth;
        EXPECT_TRUE(agrees(mean(), 3, 0.01, 0.01)) << depth;
    }
}

// At the last bounce, too, rays and samples share what comes through.
TEST_F(LightCounting, AVeilBeforeALampTakesItsShare) {
    addSquare("/plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    look("/plate", metal(0.45f));
    addLamp();
    lookAt({0.4, 0, 0.5}, {0, 0, 0}, 1e-3);
    PreviewSurface veil = lambert(0);
    veil.opacity = 0.25f;
    for (const int depth : {0, 3}) {
        settings_.maxDepth = depth;
        scene_.removeMesh("/veil");
        const double without = mean().mean;
        addSquare("/veil", {0, 0, 0.7f}, {3, 0, 0}, {0, 3, 0});
        look("/veil", veil);
        EXPECT_TRUE(agrees(mean(), 0.75 * without, 0.01, 4e-3 * without)) << depth;
    }
}

// So do they where a light throws no shadows: samples find it behind anything.
TEST_F(LightCounting, ALampWithoutShadowsCountsOnceBehindAWall) {
    addSquare("/plate", {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    look("/plate", metal(0.45f));
    addLamp();
    Light lamp = scene_.lights().at("/lamp");
    lamp.shadows = false;
    scene_.setLight("/lamp", lamp);
    lookAt({0.4, 0, 0.5}, {0, 0, 0}, 1e-3);
    const double without = mean().mean;
    addSquare("/wall", {0, 0, 0.7f}, {3, 0, 0}, {0, 3, 0});
    look("/wall", lambert(0));
    EXPECT_GT(without, 0.1);
    EXPECT_TRUE(agrees(mean(), without, 0.01, 4e-3 * without));
}

// A metal plate in a shell that absorbs, under a dome: quadrature of its lobe.
TEST_F(LightCounting, ASurfaceInAShellTakesTheDomeOnce) {
    const double depth = 0.75;
    const PreviewSurface plate = metal(0.5f);
    addSquare("/shell", {0, 0, 0}, {20, 0, 0}, {0, 20, 0});
    giveShell("/shell");
    addSquare("/plate", {0, 0, float(-depth)}, {20, 0, 0}, {0, 20, 0});
    look("/plate", plate);
    Light dome;
    dome.type = Light::Type::Dome;
    dome.emission = Rgb(1.0f);
    scene_.setLight("/dome", dome);
    lookAt({0, 0, 10}, {0, 0, 0}, 1e-3);
    TextureStore none;
    const PreviewBsdf bsdf(PlainMaterial("/m", plate, none, {}).at({}, Rgb(0.0f)));
    double expected = 0;
    constexpr int n = 4000;
    for (int i = 0; i < n; ++i) {
        const double mu = (i + 0.5) / n, s = std::sqrt(1 - mu * mu);
        expected += double(bsdf.evaluate({0, 0, 1}, {float(s), 0, float(mu)}).y) * mu *
                    std::exp(-kExtinction * depth / mu) * 2 * kPi / n;
    }
    expected *= std::exp(-kExtinction * depth);
    for (const int bounces : {0, 3}) {
        settings_.maxDepth = bounces;
        EXPECT_TRUE(agrees(mean(), expected, 0.01, 0.01 * expected)) << bounces;
    }
}

// Light goes through a shell's edge to a surface: to samples of a small light and of a wide one, and to rays as well.
TEST_F(LightCounting, LightThroughAShellsEdge) {
    addCubeBeforeWall(1);
    look("/wall", lambert(0.6f));
    addSun(0);
    EXPECT_TRUE(agrees(mean(), 0.6 * std::exp(-kExtinction * std::sqrt(2.0)), 0.01, 0.01));
    const double half = 5;
    addSun(half);
    const Vec3d on(wallMiddle()), z = normalize(Vec3d(-1, -1, 0));
    const double white = overSun(half, [&](const Vec3d& d) { return std::exp(-kExtinction * wayThroughCube(on, d)); });
    EXPECT_TRUE(agrees(mean(), 0.6 * white, 0.01, 0.01));

    const PreviewSurface glossy = metal(0.6f);
    look("/wall", glossy);
    TextureStore none;
    const PreviewBsdf bsdf(PlainMaterial("/m", glossy, none, {}).at({}, Rgb(0.0f)));
    Vec3d x, y;
    orthonormalBasis(z, x, y);
    const auto local = [&](const Vec3d& d) { return Vec3f(float(dot(d, x)), float(dot(d, y)), float(dot(d, z))); };
    const Vec3f out = local(normalize(Vec3d(-1.4, -1.4, 1.5)));
    // Irradiance pi of the whole disc; its cosine is that of the projected solid angle.
    const double seen = overSun(half, [&](const Vec3d& d) {
        return kPi * double(bsdf.evaluate(out, local(d)).y) * std::exp(-kExtinction * wayThroughCube(on, d));
    });
    for (const int depth : {0, 3}) {
        settings_.maxDepth = depth;
        EXPECT_TRUE(agrees(mean(), seen, 0.01, 0.01 * seen)) << depth;
    }
}

// No sample brings more than a surface in full light would show; behind a shell that bends rays, where only rays find
// the light, no more than that of the blurred disc.
TEST_F(LightCounting, NoPathIsAFirefly) {
    settings_.samples = 1;
    settings_.pixelFilter = "box";
    const auto brightest = [&] {
        double most = 0;
        for (settings_.seed = 0; settings_.seed < 4; ++settings_.seed) {
            const std::vector<double> p = pixels(128);
            most = std::max(most, *std::max_element(p.begin(), p.end()));
        }
        return most;
    };
    const double half = 5, albedo = 0.6;
    addSun(half);
    addCubeBeforeWall(1);
    look("/wall", lambert(float(albedo)));
    EXPECT_LE(brightest(), albedo * 1.001);
    addCubeBeforeWall(1.02f); // bends little: the sun is seen through its edge
    look("/wall", lambert(float(albedo)));
    const auto disc = [&](double angle) { return albedo / std::pow(std::sin(angle), 2); };
    EXPECT_LE(brightest(), albedo + disc(0.5) * 1.001);
    settings_.regularize = false;
    const double sharp = brightest();
    EXPECT_GT(sharp, albedo + 2 * disc(0.5));
    EXPECT_LE(sharp, albedo + disc(half * kPi / 180) * 1.001);
}

} // namespace
} // namespace stf::test
