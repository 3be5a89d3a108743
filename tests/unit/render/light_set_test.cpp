// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_set.h"

#include "stfLib/base/random.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr float kPi = 3.14159265f;

std::map<std::string, Light> one(const Light& light) {
    return {{"/light", light}};
}

// Irradiance of a surface by sampling, with its standard error.
struct Irradiance {
    double mean, error;
};
Irradiance irradiance(const LightSet& lights, const Vec3f& normal, int n) {
    CounterRng rng(7, 0);
    double sum = 0, squares = 0;
    for (int i = 0; i < n; ++i) {
        const float u = rng.uniform(), v = rng.uniform();
        const LightSample s = lights.sample(0, {0, 0, 0}, normal, {u, v});
        const double e = double(s.irradiance.y) * double(std::max(0.0f, dot(normal, s.towards)));
        sum += e;
        squares += e * e;
    }
    const double mean = sum / n;
    return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / n)};
}

TEST(LightSet, DistantIrradianceAndRadiance) {
    Light l;
    l.emission = Rgb(2.0f);
    EXPECT_NEAR(irradiance(LightSet(one(l), {}), {0, 0, 1}, 16).mean, 2.0, 1e-6); // angle 0: irradiance
    l.angle = 20;
    l.normalize = true;
    const Irradiance normalized = irradiance(LightSet(one(l), {}), {0, 0, 1}, 20000);
    // A disc of 20 degrees shines a little slantwise: cos averaged over it.
    const double half = 10 * double(kPi) / 180, s2 = std::sin(half) * std::sin(half);
    const double meanCosine = 2.0 / 3.0 * (1 - std::pow(1 - s2, 1.5)) / s2;
    EXPECT_NEAR(normalized.mean, 2.0 * meanCosine, 4 * normalized.error + 1e-6);
    l.normalize = false; // `emission` is radiance
    const Irradiance radiance = irradiance(LightSet(one(l), {}), {0, 0, 1}, 20000);
    EXPECT_NEAR(radiance.mean, 2.0 * double(kPi) * s2 * meanCosine, 4 * radiance.error + 1e-6);
}

TEST(LightSet, UniformDomeGivesPi) {
    Light l;
    l.type = Light::Type::Dome;
    l.emission = Rgb(1.0f);
    const LightSet lights(one(l), {});
    for (const Vec3f& n : {Vec3f(0, 0, 1), Vec3f(0.6f, -0.8f, 0)}) {
        const Irradiance e = irradiance(lights, n, 20000);
        EXPECT_LT(e.error, 0.02);
        EXPECT_NEAR(e.mean, double(kPi), 4 * e.error);
    }
    EXPECT_EQ(lights.background({0, 1, 0}), Rgb(1.0f));
}

// A dome that shines from the upper half only (a picture of two rows): a surface that faces the pole gets pi, one that
// looks sideways half of it. The mixture of densities must not change that.
TEST(LightSet, TexturedDome) {
    const auto path = std::filesystem::temp_directory_path() / "stf_dome_test.ppm";
    {
        std::ofstream file(path, std::ios::binary);
        file << "P6\n4 2\n255\n";
        for (int i = 0; i < 12; ++i) {
            file.put(char(255));
        }
        for (int i = 0; i < 12; ++i) {
            file.put(char(0));
        }
    }
    Light l;
    l.type = Light::Type::Dome;
    l.emission = Rgb(1.0f);
    l.textureFile = path.string();
    std::string said;
    const LightSet lights(one(l), [&](Severity, const std::string& text) { said += text; });
    EXPECT_EQ(said, "");
    // Bilinear lookup blends the two rows: radiance falls linearly from 1 at polar angle pi/4 to 0 at 3 pi/4.
    double up = 0, side = 0;
    const int n = 4000;
    for (int i = 0; i < n; ++i) {
        const double theta = (i + 0.5) / n * double(kPi),
                     radiance = std::clamp(1.5 - theta / (double(kPi) / 2), 0.0, 1.0);
        const double ring = std::sin(theta) * double(kPi) / n * radiance;
        up += 2 * double(kPi) * ring * std::max(0.0, std::cos(theta));
        side += 2 * ring * std::sin(theta); // INT max(0, cos phi) dphi = 2
    }
    const Irradiance a = irradiance(lights, {0, 1, 0}, 40000), b = irradiance(lights, {1, 0, 0}, 40000);
    EXPECT_NEAR(a.mean, up, 4 * a.error + 1e-3);
    EXPECT_NEAR(b.mean, side, 4 * b.error + 1e-3);
    std::filesystem::remove(path);
}

TEST(LightSet, BadLights) {
    Light l;
    l.emission = Rgb(std::nanf(""));
    std::string said;
    const MessageSink sink = [&](Severity, const std::string& text) { said += text; };
    EXPECT_EQ(LightSet(one(l), sink).count(), 0u);
    EXPECT_NE(said.find("/light"), std::string::npos);
    l.emission = Rgb(0.0f);
    EXPECT_EQ(LightSet(one(l), sink).count(), 0u);
    l.emission = Rgb(1.0f);
    l.visible = false;
    EXPECT_EQ(LightSet(one(l), sink).count(), 0u);
    l.visible = true;
    l.type = Light::Type::Dome;
    l.textureFile = "/does/not/exist.exr";
    said.clear();
    EXPECT_EQ(LightSet(one(l), sink).count(), 1u) << "uniform instead";
    EXPECT_NE(said.find("exist.exr"), std::string::npos);
}

} // namespace
} // namespace stf::test
