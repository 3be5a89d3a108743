// SPDX-License-Identifier: Apache-2.0
// What lies between the scene and the pixels: lens, shutter, exposure, windows. Against closed forms.
#include "stfLib/render/renderer.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/files.h"
#include "tests/unit/support/square_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr Matrix4 kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Matrix4 perspective(double focal) {
    const double n = 0.1, f = 1000;
    return {focal, 0, 0, 0, 0, focal, 0, 0, 0, 0, -(f + n) / (f - n), -1, 0, 0, -2 * f * n / (f - n), 0};
}

Matrix4 orthographic(double scale) {
    const double n = 0.1, f = 1000;
    return {scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, -2 / (f - n), 0, 0, 0, -(f + n) / (f - n), 1};
}

Transform moved(const Vec3d& by) {
    Transform t;
    t.translation = by;
    return t;
}

/// The share of the unit disc on the side of the line at distance x from its middle where the middle is for x > 0.
double discShare(double x) {
    x = std::clamp(x, -1.0, 1.0);
    return 0.5 + (x * std::sqrt(1 - x * x) + std::asin(x)) / kPi;
}

class Frame : public ::testing::Test {
protected:
    void SetUp() override {
        settings_.samples = 1024;
        settings_.maxDepth = 0;
        settings_.pixelFilter = "box";
        settings_.pixelFilterWidth = 1e-3f; // a pixel is a point
        scene_.setMetersPerUnit(0.001);
    }

    /// A square with half its edges as vectors; its front is on the side of their cross product.
    void addSquare(const std::string& id, const Vec3f& middle, const Vec3f& x, const Vec3f& y, const Rgb& albedo,
                   const Rgb& emission, std::vector<TransformSample> motion = {}) {
        scene_.setMesh(id, squareMesh(middle, x, y), 0);
        MeshInstance instance;
        instance.motion = std::move(motion);
        scene_.setInstances(id, {instance});
        PreviewSurface s;
        s.diffuseColor = albedo;
        s.emissiveColor = emission;
        s.ior = 1;
        scene_.setMaterial(id + "/look", s);
        scene_.setMeshMaterial(id, id + "/look");
    }

    void render(const Camera& camera, const FrameWindow& window) {
        renderer_.setSettings(settings_);
        renderer_.setCamera(camera, window);
        Progress progress;
        renderer_.prepare(scene_, progress);
        renderer_.restart();
        while (!renderer_.converged()) {
            ASSERT_TRUE(renderer_.renderPass(progress));
        }
    }
    void render(const Camera& camera, int width, int height) { render(camera, {width, height, 0, 0, width, height}); }

    /// The red of every pixel of one row agrees with what is expected of its place (-1..1): within four standard
    /// errors, which have to be small, and rounding.
    void expectRow(const std::function<double(double)>& expected, double error = 0.02) {
        const Film& film = renderer_.film();
        const std::vector<float> color = film.read(Aov::Color), variance = film.read(Aov::Variance);
        for (int x = 0; x < film.width(); ++x) {
            const double at = 2 * (x + 0.5) / film.width() - 1, sigma = std::sqrt(double(variance[std::size_t(3 * x)]));
            EXPECT_LT(sigma, error);
            EXPECT_NEAR(double(color[std::size_t(4 * x)]), expected(at), 4 * sigma + 2e-3) << "at " << at;
        }
    }

    RenderSettings settings_;
    Scene scene_;
    Renderer renderer_;
};

// A shining half plane at depth z: what a pixel sees of it is the share of its circle of confusion, whose radius is
// R |z - f| / f there.
TEST_F(Frame, CircleOfConfusionOfAnEdge) {
    for (double depth : {4.0, 8.0, 14.0}) {
        addSquare("/edge", Vec3f(50, 0, float(-depth)), {50, 0, 0}, {0, 50, 0}, Rgb(0.0f), Rgb(1.0f));
        CameraOptics optics;
        optics.lens = {0.5, 8.0};
        const double circle = std::max(1e-9, 0.5 * std::abs(depth - 8) / 8);
        render(Camera(kIdentity, perspective(4), optics), 24, 1);
        expectRow([&](double ndc) { return discShare(ndc / 4 * depth / circle); });
        render(Camera(kIdentity, orthographic(2), optics), 24, 1);
        expectRow([&](double ndc) { return discShare(ndc / 2 / circle); });
        settings_.depthOfField = false;
        render(Camera(kIdentity, perspective(4), optics), 24, 1);
        expectRow([](double ndc) { return ndc > 0 ? 1.0 : 0.0; });
        settings_.depthOfField = true;
    }
}

TEST(CameraLens, RaysOfAPixelMeetInTheFocus) {
    CameraOptics optics;
    optics.lens = {0.25, 10};
    const Camera c(kIdentity, perspective(2), optics);
    const Vec3d focus(0.3 / 2 * 10, -0.7 / 2 * 10, -10);
    for (const Vec2f& u : {Vec2f(0.5f, 0.5f), Vec2f(0.1f, 0.9f), Vec2f(0.99f, 0.3f)}) {
        const Vec2d onLens = onUnitDisc(u);
        const Ray r = c.ray(0.3, -0.7, Vec3d(0.0), onLens, 0.5f);
        EXPECT_NEAR(r.origin.z, -0.1f, 1e-6f); // starts on the near plane
        const Vec3d o(r.origin), d(r.direction);
        EXPECT_LT(length(o + d * ((-10 - o.z) / d.z) - focus), 1e-5);
        const Vec3d lens = o + d * (-o.z / d.z);
        EXPECT_NEAR(lens.x, 0.25 * onLens.x, 1e-6);
        EXPECT_NEAR(lens.y, 0.25 * onLens.y, 1e-6);
    }
    EXPECT_EQ(c.pinhole().ray(0.3, -0.7).direction, c.ray(0.3, -0.7, Vec3d(0.0), {0, 0}, 0.5f).direction);
}

// One lens sample per pixel stands for all of the circle of confusion, n of them each for their part.
TEST(CameraLens, ConesWidenWithTheCircleOfConfusion) {
    CameraOptics optics;
    optics.lens = {0.25, 10};
    const Camera sharp(kIdentity, perspective(2)), lens(kIdentity, perspective(2), optics);
    for (const Vec2d& at : {Vec2d(0, 0), Vec2d(0.6, -0.8)}) {
        const double slant = std::sqrt(1 + (at.x * at.x + at.y * at.y) / 4); // way per depth
        for (double depth : {0.1, 4.0, 10.0, 35.0}) {
            const float way = float((depth - 0.1) * slant);
            const double more =
                double(lens.cone(at.x, at.y, 0.01, 0.01).at(way)) - double(sharp.cone(at.x, at.y, 0.01, 0.01).at(way));
            EXPECT_NEAR(more, 2 * 0.25 * std::abs(depth - 10) / 10, 1e-4) << depth;
            const double part = double(lens.cone(at.x, at.y, 0.01, 0.01, 64).at(way)) -
                                double(sharp.cone(at.x, at.y, 0.01, 0.01).at(way));
            EXPECT_NEAR(part, more / 8, 1e-4);
        }
    }
}

TEST(CameraLens, DiscIsUniform) {
    constexpr int kEdge = 400;
    double squares = 0, right = 0;
    for (int i = 0; i < kEdge * kEdge; ++i) {
        const Vec2d p = onUnitDisc({(float(i % kEdge) + 0.5f) / kEdge, (float(i / kEdge) + 0.5f) / kEdge});
        const double r2 = p.x * p.x + p.y * p.y;
        EXPECT_LE(r2, 1.0);
        squares += r2;
        right += p.x > 0.4 ? 1 : 0;
    }
    EXPECT_NEAR(squares / (kEdge * kEdge), 0.5, 1e-4); // mean of r^2 over a disc
    EXPECT_NEAR(right / (kEdge * kEdge), discShare(-0.4), 2e-3);
}

// A shining half plane that moves on by 2: a pixel sees it for the share of the time that its edge has passed.
TEST_F(Frame, BlurOfAnEdgeThatMoves) {
    const std::vector<TransformSample> way = {{-0.5, moved({-1, 0, 0})}, {0.5, moved({1, 0, 0})}};
    addSquare("/edge", Vec3f(50, 0, -8), {50, 0, 0}, {0, 50, 0}, Rgb(0.0f), Rgb(1.0f), way);
    CameraOptics optics;
    optics.shutter = {-0.5, 0.5};
    render(Camera(kIdentity, orthographic(0.5), optics), 24, 1);
    expectRow([](double ndc) { return std::clamp((2 * ndc + 1) / 2, 0.0, 1.0); });
    // Half as long open: half the blur, from -0.5 to 0.5.
    optics.shutter = {-0.25, 0.25};
    render(Camera(kIdentity, orthographic(0.5), optics), 24, 1);
    expectRow([](double ndc) { return std::clamp(2 * ndc + 0.5, 0.0, 1.0); });
    settings_.motionBlur = false;
    render(Camera(kIdentity, orthographic(0.5), optics), 24, 1);
    expectRow([](double ndc) { return ndc > 0 ? 1.0 : 0.0; });
}

// The same from a camera that moves, which sees the edge go the other way.
TEST_F(Frame, BlurOfACameraThatMoves) {
    addSquare("/edge", Vec3f(50, 0, -8), {50, 0, 0}, {0, 50, 0}, Rgb(0.0f), Rgb(1.0f));
    CameraOptics optics;
    optics.shutter = {0, 1};
    optics.viewToWorld = {{0, moved({0, 0, 0})}, {1, moved({1, 0, 0})}};
    render(Camera(kIdentity, orthographic(0.5), optics), 24, 1);
    expectRow([](double ndc) { return std::clamp(2 * ndc + 1, 0.0, 1.0); });
}

// A square of edge 2 that makes a quarter turn about its corner at the middle of the image: the share of the time that
// a point at the angle p lies in it is p / 90 degrees before, and 1 - (p - 90) / 90 after.
TEST_F(Frame, BlurOfAQuarterTurn) {
    Transform turned;
    turned.x = {0, 1, 0};
    turned.y = {-1, 0, 0};
    const std::vector<TransformSample> way = {{0, Transform()}, {1, turned}};
    addSquare("/square", Vec3f(1, 1, -8), {1, 0, 0}, {0, 1, 0}, Rgb(0.0f), Rgb(1.0f), way);
    CameraOptics optics;
    optics.shutter = {0, 1};
    render(Camera(kIdentity, orthographic(1), optics), 8, 8);
    const std::vector<float> color = renderer_.film().read(Aov::Color), v = renderer_.film().read(Aov::Variance);
    for (int i = 0; i < 64; ++i) {
        const double x = (i % 8 + 0.5) / 4 - 1, y = (i / 8 + 0.5) / 4 - 1;
        const double angle = std::atan2(y, x) / (kPi / 2); // in quarters; the lower half is never covered
        const double share = y < 0 ? 0 : angle < 1 ? angle : 2 - angle;
        EXPECT_NEAR(double(color[std::size_t(4 * i)]), share, 4 * std::sqrt(double(v[std::size_t(3 * i)])) + 3e-3)
            << x << " " << y;
    }
}

// The shadow of a half plane that moves, thrown straight down: light for the share of the time it has not passed.
TEST_F(Frame, ShadowsAreOfTheSameTime) {
    addSquare("/floor", Vec3f(0, 0, -8), {5, 0, 0}, {0, 5, 0}, Rgb(0.5f), Rgb(0.0f));
    addSquare("/shade", Vec3f(50, 0, 8), {50, 0, 0}, {0, 50, 0}, Rgb(0.0f), Rgb(0.0f), // behind the camera
              {{0, moved({-1, 0, 0})}, {1, moved({1, 0, 0})}});
    Light sun;
    sun.type = Light::Type::Distant;
    sun.emission = Rgb(float(kPi)); // shines along -z: radiance off the floor 0.5
    scene_.setLight("/sun", sun);
    CameraOptics optics;
    optics.shutter = {0, 1};
    render(Camera(kIdentity, orthographic(0.5), optics), 24, 1);
    expectRow([](double ndc) { return 0.5 * (1 - std::clamp((2 * ndc + 1) / 2, 0.0, 1.0)); });
}

// A shell and a camera that move together see each other at rest: the volume's rays go by the time of their path.
TEST_F(Frame, AShellThatMovesWithTheCameraIsSharp) {
    const TemporaryFolder folder;
    const std::string path = folder.file("marble.vdb");
    SampleOptions small;
    small.size = {24, 24, 8};
    small.voxelMm = 1;
    writeBaseVolume(makeSample("marble", small), path);
    settings_.samples = 64;
    settings_.quality = 0.1f;
    const auto picture = [&](bool move) {
        addSquare("/shell", Vec3f(0, 0, -60), {20, 0, 0}, {0, 20, 0}, Rgb(0.5f), Rgb(0.0f));
        StfBinding binding;
        binding.baseVolume = path;
        scene_.setStf("/shell", binding);
        Light sun;
        sun.type = Light::Type::Distant;
        sun.emission = Rgb(1.0f);
        scene_.setLight("/sun", sun);
        CameraOptics optics;
        MeshInstance instance;
        if (move) {
            instance.motion = {{0, moved({-30, 0, 0})}, {1, moved({30, 0, 0})}};
            optics.shutter = {0, 1};
            optics.viewToWorld = instance.motion;
        }
        scene_.setInstances("/shell", {instance});
        render(Camera(kIdentity, perspective(4), optics), 16, 16);
        return std::make_pair(renderer_.film().read(Aov::Color), renderer_.film().read(Aov::Variance));
    };
    const auto still = picture(false), moving = picture(true);
    double difference = 0, noise = 0, contrast = 0, mean = 0;
    for (std::size_t i = 0; i < 256; ++i) {
        const double d = double(moving.first[4 * i]) - double(still.first[4 * i]);
        difference += d * d / 256;
        noise += double(moving.second[3 * i] + still.second[3 * i]) / 256;
        mean += double(still.first[4 * i]) / 256;
    }
    for (std::size_t i = 0; i < 256; ++i) {
        contrast += std::pow(double(still.first[4 * i]) - mean, 2) / 256;
    }
    EXPECT_GT(mean, 0.01);
    EXPECT_GT(contrast, 20 * noise); // veins that a blur would take away
    // 256 squared differences, each of mean `noise`: their mean has a relative error of sqrt(2 / 256).
    EXPECT_LT(difference, noise * (1 + 5 * std::sqrt(2.0 / 256)) + 1e-6);
}

TEST_F(Frame, ExposureScalesColoursOnce) {
    settings_.samples = 16;
    addSquare("/edge", Vec3f(50.1f, 0, -8), {50, 0, 0}, {0, 50, 0}, Rgb(0.25f), Rgb(0.5f));
    renderer_.setClearColor({0.125f, 0.25f, 0.5f}, 1);
    CameraOptics optics;
    settings_.pixelFilterWidth = 1; // the middle pixel has a variance
    render(Camera(kIdentity, orthographic(1), optics), 3, 1);
    std::map<Aov, std::vector<float>> plain, exposed;
    const Aov aovs[] = {Aov::Color, Aov::Variance, Aov::Albedo, Aov::Depth, Aov::CameraDepth};
    for (Aov aov : aovs) {
        plain[aov] = renderer_.film().read(aov);
    }
    optics.exposure = 2;
    render(Camera(kIdentity, orthographic(1), optics), 3, 1);
    for (Aov aov : aovs) {
        exposed[aov] = renderer_.film().read(aov);
    }
    EXPECT_FLOAT_EQ(exposed[Aov::Color][8], 4 * 0.5f);
    EXPECT_FLOAT_EQ(exposed[Aov::Color][2], 0.5f); // the backdrop stays
    EXPECT_FLOAT_EQ(exposed[Aov::Color][11], plain[Aov::Color][11]);
    EXPECT_GT(plain[Aov::Variance][3], 0.0f);
    const double edge = std::sqrt(double(exposed[Aov::Variance][3] / plain[Aov::Variance][3]));
    EXPECT_NEAR(edge, (2 - 0.125) / (0.5 - 0.125), 1e-3); // between the backdrop and what shines
    for (Aov aov : {Aov::Albedo, Aov::Depth, Aov::CameraDepth}) {
        EXPECT_EQ(exposed[aov], plain[aov]);
    }
}

// Every pixel of a window, within the frame and beyond it, is that of the frame, bit for bit.
TEST_F(Frame, WindowsShowTheSamePixels) {
    settings_.samples = 4;
    settings_.pixelFilter = "blackmanHarris";
    settings_.pixelFilterWidth = 0;
    settings_.maxDepth = 2;
    const std::vector<TransformSample> way = {{0, moved({-1, 0, 0})}, {1, moved({1, 0, 0})}};
    addSquare("/a", Vec3f(1, 0, -8), {2, 0, 0.5f}, {0, 2, 0}, Rgb(0.5f), Rgb(0.2f), way);
    addSquare("/b", Vec3f(-1, 0, -10), {3, 0, 0}, {0, 3, 0}, Rgb(0.7f, 0.2f, 0.1f), Rgb(0.1f));
    CameraOptics optics;
    optics.lens = {0.2, 9};
    optics.shutter = {0, 1};
    const Camera camera(kIdentity, perspective(2), optics);
    render(camera, 30, 20);
    const auto color = renderer_.film().read(Aov::Color), depth = renderer_.film().read(Aov::Depth);
    const auto ids = renderer_.film().readIds(Aov::ElementId);
    for (const FrameWindow& w : {FrameWindow{30, 20, 7, 5, 13, 11}, FrameWindow{30, 20, -4, -3, 38, 25}}) {
        render(camera, w);
        const auto c = renderer_.film().read(Aov::Color), d = renderer_.film().read(Aov::Depth);
        const auto e = renderer_.film().readIds(Aov::ElementId);
        int compared = 0;
        for (int y = 0; y < w.height; ++y) {
            for (int x = 0; x < w.width; ++x) {
                const int fx = x + w.x, fy = y + w.y;
                if (fx < 0 || fy < 0 || fx >= 30 || fy >= 20) {
                    continue;
                }
                const std::size_t in = std::size_t(y * w.width + x), whole = std::size_t(fy * 30 + fx);
                EXPECT_EQ(d[in], depth[whole]);
                EXPECT_EQ(e[in], ids[whole]);
                for (std::size_t k = 0; k < 4; ++k) {
                    EXPECT_EQ(c[4 * in + k], color[4 * whole + k]) << fx << " " << fy;
                }
                ++compared;
            }
        }
        EXPECT_EQ(compared, std::min(w.width, 30) * std::min(w.height, 20));
    }
}

TEST_F(Frame, ThePlanSaysWhatBlurs) {
    settings_.samples = 1;
    addSquare("/edge", Vec3f(50, 0, -8), {50, 0, 0}, {0, 50, 0}, Rgb(0.0f), Rgb(1.0f));
    const auto runs = [&](const std::string& stage) {
        const std::vector<PlanEntry> plan = renderer_.plan();
        const auto it = std::find_if(plan.begin(), plan.end(), [&](const PlanEntry& e) { return e.stage == stage; });
        return it != plan.end() && it->runs;
    };
    CameraOptics optics;
    optics.shutter = {0, 1};
    render(Camera(kIdentity, orthographic(1), optics), 2, 1);
    EXPECT_FALSE(runs("lens"));
    EXPECT_FALSE(runs("motion"));
    optics.lens = {1, 8};
    optics.viewToWorld = {{0, moved({0, 0, 0})}, {1, moved({1, 0, 0})}};
    render(Camera(kIdentity, orthographic(1), optics), 2, 1);
    EXPECT_TRUE(runs("lens"));
    EXPECT_TRUE(runs("motion"));
    settings_.motionBlur = settings_.depthOfField = false;
    render(Camera(kIdentity, orthographic(1), optics), 2, 1);
    EXPECT_FALSE(runs("lens"));
    EXPECT_FALSE(runs("motion"));
}

} // namespace
} // namespace stf::test
