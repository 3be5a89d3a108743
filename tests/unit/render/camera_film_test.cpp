// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/error.h"
#include "stfLib/base/sampler.h"
#include "stfLib/render/camera.h"
#include "stfLib/render/film.h"

#include <gtest/gtest.h>

namespace stf::test {
namespace {

// Perspective with focal length 2, near 0.1, far 1000, camera at (3, 4, 5) far from or near the origin.
Camera perspective(double offset) {
    const Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -3 - offset, -4, -5, 1};
    const double n = 0.1, f = 1000;
    const Matrix4 projection{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, -(f + n) / (f - n), -1, 0, 0, -2 * f * n / (f - n), 0};
    return Camera(view, projection);
}

TEST(Camera, RaysGoThroughTheirPixel) {
    const Camera c = perspective(0);
    const Ray middle = c.ray(0, 0);
    EXPECT_NEAR(middle.direction.z, -1, 1e-6f);
    EXPECT_NEAR(middle.origin.x, 3, 1e-5f);
    const Ray corner = c.ray(1, -1); // tangent 1/2 to the side and down
    EXPECT_NEAR(corner.direction.x / -corner.direction.z, 0.5f, 1e-5f);
    EXPECT_NEAR(corner.direction.y / -corner.direction.z, -0.5f, 1e-5f);
    const Vec3d p = Vec3d(corner.origin) + Vec3d(corner.direction) * 20.0;
    EXPECT_NEAR(c.viewDepth(p), 5 - p.z, 1e-9);
    EXPECT_GT(c.ndcDepth(p), 0.9);
    EXPECT_LT(c.ndcDepth(p), 1.0);
}

// A pixel of 1/50 of the image's height, seen with focal length 2, is a hundredth of its distance wide.
TEST(Camera, AConeIsAsWideAsItsPixel) {
    for (double offset : {0.0, 1e6}) {
        const RayCone cone = perspective(offset).cone(0.01, -0.01, 0.02, 0.02);
        EXPECT_NEAR(cone.at(20), 0.2, 0.002); // from the near plane, a tenth of a unit on
        EXPECT_NEAR(cone.at(0), 0.001, 5e-5);
    }
}

TEST(Camera, FarFromTheOrigin) {
    const Ray r = perspective(1e6).ray(0.5, 0.5);
    EXPECT_NEAR(r.direction.x / -r.direction.z, 0.25f, 1e-5f);
}

TEST(Camera, SingularMatrixIsRefused) {
    const Matrix4 zero{};
    const Matrix4 identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    EXPECT_THROW(Camera(zero, identity), Error);
}

// Samples that are stratified among each other err less than independent ones: what the film tells of a pixel agrees
// with the scatter of many pixels. A quarter disc, whose variance for independent numbers is known to be three times as
// much.
TEST(Film, ErrorOfStratifiedSamples) {
    constexpr int kSide = 64, kSamples = 64;
    Film film;
    film.resize(kSide, kSide);
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            for (std::uint32_t k = 0; k < kSamples; ++k) {
                PixelSampler sampler(1, std::uint64_t(y * kSide + x), k);
                const Vec2f u = sampler.next2d(), v = sampler.next2d();
                PixelSample s;
                s.color = Rgb((u.x * u.x + u.y * u.y < 1 ? 1.0f : 0.0f) + 0.5f * v.x + 0.2f * u.x * v.y);
                film.add(x, y, s);
            }
        }
    }
    const std::vector<float> color = film.read(Aov::Color), variance = film.read(Aov::Variance);
    double mean = 0, squares = 0, told = 0;
    constexpr int kPixels = kSide * kSide;
    for (int i = 0; i < kPixels; ++i) {
        const double c = double(color[std::size_t(4 * i)]);
        mean += c / kPixels;
        squares += c * c / kPixels;
        told += double(variance[std::size_t(3 * i)]) / kPixels;
    }
    const double real = squares - mean * mean, independent = 0.2 / kSamples;
    EXPECT_LT(real, 0.5 * independent);
    EXPECT_GT(told, 0.9 * real) << "never told too small by much";
    EXPECT_LT(told, 0.75 * independent);
}

TEST(Film, MeanVarianceAndCounts) {
    Film film;
    film.resize(2, 1);
    for (int i = 0; i < 4; ++i) {
        PixelSample s;
        s.color = Rgb(float(i)); // 0 1 2 3: mean 1.5, variance of the mean (5/3) / 4
        s.alpha = 1;
        film.add(1, 0, s);
    }
    const std::vector<float> color = film.read(Aov::Color), variance = film.read(Aov::Variance);
    EXPECT_FLOAT_EQ(color[4], 1.5f);
    EXPECT_FLOAT_EQ(color[7], 1.0f);
    EXPECT_FLOAT_EQ(color[0], 0.0f);
    EXPECT_NEAR(variance[3], 5.0 / 12.0, 1e-6);
    EXPECT_FLOAT_EQ(film.read(Aov::SampleCount)[1], 4.0f);
    EXPECT_EQ(film.readIds(Aov::PrimId)[0], -1);
    EXPECT_FLOAT_EQ(film.read(Aov::Depth)[0], 1.0f);
    film.clear();
    EXPECT_FLOAT_EQ(film.read(Aov::SampleCount)[1], 0.0f);
}

TEST(Film, NamesOfAovs) {
    Aov aov = Aov::Color;
    for (const char* name :
         {"color", "alpha", "depth", "cameraDepth", "normal", "Neye", "position", "albedo", "primId", "instanceId",
          "elementId", "sampleCount", "variance", "stf:single", "stf:multiple", "stf:core", "stf:reflection"}) {
        EXPECT_TRUE(aovFromName(name, aov)) << name;
        EXPECT_GE(aovChannels(aov), 1);
    }
    EXPECT_FALSE(aovFromName("nothing", aov));
}

} // namespace
} // namespace stf::test
