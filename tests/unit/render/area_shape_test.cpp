// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/area_shape.h"

#include "stfLib/base/random.h"

#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

Light light(Light::Type type) {
    Light l;
    l.type = type;
    l.radius = 0.7f;
    l.width = 1.5f;
    l.height = 0.8f;
    l.length = 2.5f;
    return l;
}

Transform lookingDown(const Vec3d& at) { // local -z is -z already
    Transform t;
    t.translation = at;
    return t;
}

// Irradiance of a plate at the origin by a light of radiance 1: mean of cosine over density, and its standard error.
struct Measured {
    double mean, error, solid, solidError;
};
Measured irradiance(const AreaShape& s, const Vec3f& point, const Vec3f& normal, int n = 40000) {
    CounterRng rng(3, 1);
    double e[2] = {0, 0}, w[2] = {0, 0};
    for (int i = 0; i < n; ++i) {
        const float u = rng.uniform(), v = rng.uniform();
        const ShapeSample x = s.sample(point, {u, v});
        const double value = double(x.solidAngle) * std::max(0.0, double(dot(x.towards, normal)));
        e[0] += value / n;
        e[1] += value * value / n;
        w[0] += double(x.solidAngle) / n;
        w[1] += double(x.solidAngle) * double(x.solidAngle) / n;
    }
    return {e[0], std::sqrt(std::max(0.0, e[1] - e[0] * e[0]) / n), w[0],
            std::sqrt(std::max(0.0, w[1] - w[0] * w[0]) / n)};
}

// Irradiance by brute force: rays in all directions over the plate, by their cosine.
Measured byRays(const AreaShape& s, const Vec3f& point, int n = 400000) {
    CounterRng rng(4, 1);
    double hits = 0;
    for (int i = 0; i < n; ++i) {
        const float r = std::sqrt(rng.uniform()), phi = 2 * float(kPi) * rng.uniform();
        const Vec3f d(r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r * r));
        hits += s.intersect(point, d) < 1e30f;
    }
    const double p = hits / n;
    return {kPi * p, kPi * std::sqrt(p * (1 - p) / n), 0, 0};
}

TEST(AreaShape, SphereAndDiskOnTheirAxis) {
    const double h = 2;
    const auto sphere = AreaShape::make(light(Light::Type::Sphere), lookingDown({0, 0, h}));
    const Measured s = irradiance(*sphere, {0, 0, 0}, {0, 0, 1});
    EXPECT_NEAR(s.mean, kPi * 0.49 / (h * h), 4 * s.error + 1e-6);
    EXPECT_NEAR(s.solid, 2 * kPi * (1 - std::sqrt(1 - 0.49 / (h * h))), 1e-6);
    EXPECT_NEAR(sphere->area(), 4 * kPi * 0.49, 1e-6);
    const auto disk = AreaShape::make(light(Light::Type::Disk), lookingDown({0, 0, h}));
    const Measured d = irradiance(*disk, {0, 0, 0}, {0, 0, 1});
    EXPECT_NEAR(d.mean, kPi * 0.49 / (0.49 + h * h), 4 * d.error);
    EXPECT_NEAR(disk->area(), kPi * 0.49, 1e-6);
}

TEST(AreaShape, RectangleOverItsCorner) {
    // Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-3: a corner of the rectangle overhead.
    const double a = 1.5, b = 0.8, h = 0.6, x = a / h, y = b / h;
    const auto rect = AreaShape::make(light(Light::Type::Rect), lookingDown({0.75, 0.4, h}));
    const double f = (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                      y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
                     (2 * kPi);
    const Measured m = irradiance(*rect, {0, 0, 0}, {0, 0, 1});
    EXPECT_NEAR(m.mean, kPi * f, 4 * m.error);
    // Its solid angle is a closed form, and every sample has it.
    const double solid = std::atan(a * b / (h * std::sqrt(a * a + b * b + h * h)));
    EXPECT_NEAR(m.solid, solid, 1e-5 * solid);
    EXPECT_LT(m.solidError, 1e-6);
}

TEST(AreaShape, SamplesAgreeWithRays) {
    Transform turned = lookingDown({0.5, -0.4, 1.6});
    turned.x = {0.9, 0.1, -0.2};
    turned.y = {-0.1, 1.1, 0.3};
    turned.z = {0.25, -0.3, 0.8}; // sheared as well
    for (Light::Type type : {Light::Type::Disk, Light::Type::Rect, Light::Type::Cylinder, Light::Type::Sphere}) {
        const auto s = AreaShape::make(light(type), turned);
        ASSERT_TRUE(s);
        const Measured a = irradiance(*s, {0, 0, 0}, {0, 0, 1}), b = byRays(*s, {0, 0, 0});
        EXPECT_NEAR(a.mean, b.mean, 4 * std::hypot(a.error, b.error)) << int(type);
    }
}

TEST(AreaShape, SamplesLieOnTheLight) {
    Transform t = lookingDown({0.2, 0.1, 1.2});
    t.x = {0, 1, 0};
    t.y = {-1, 0, 0};
    CounterRng rng(5, 1);
    for (Light::Type type : {Light::Type::Disk, Light::Type::Rect, Light::Type::Cylinder, Light::Type::Sphere}) {
        const auto s = AreaShape::make(light(type), t);
        for (int i = 0; i < 500; ++i) {
            const Vec3f from(rng.uniform() - 0.5f, rng.uniform() - 0.5f, -rng.uniform());
            const ShapeSample x = s->sample(from, {rng.uniform(), rng.uniform()});
            if (x.solidAngle > 0) {
                const float hit = s->intersect(from, x.towards);
                EXPECT_NEAR(hit, x.distance, 2e-3f * x.distance) << int(type);
            }
        }
    }
}

TEST(AreaShape, OneSideAndNoInsideShines) {
    const auto rect = AreaShape::make(light(Light::Type::Rect), lookingDown({0, 0, 0}));
    EXPECT_GT(rect->sample({0.1f, 0.1f, -1}, {0.5f, 0.5f}).solidAngle, 0);
    EXPECT_EQ(rect->sample({0.1f, 0.1f, 1}, {0.5f, 0.5f}).solidAngle, 0);
    EXPECT_GT(rect->intersect({0, 0, 1}, {0, 0, -1}), 1e30f);
    // A mirrored light shines along its own -z as well.
    Transform mirrored;
    mirrored.x = {-1, 0, 0};
    const auto flipped = AreaShape::make(light(Light::Type::Disk), mirrored);
    EXPECT_GT(flipped->sample({0.1f, 0.1f, -1}, {0.5f, 0.5f}).solidAngle, 0);
    const auto sphere = AreaShape::make(light(Light::Type::Sphere), lookingDown({0, 0, 0}));
    EXPECT_EQ(sphere->sample({0.1f, 0, 0}, {0.5f, 0.5f}).solidAngle, 0);
    const auto cylinder = AreaShape::make(light(Light::Type::Cylinder), lookingDown({0, 0, 0}));
    EXPECT_EQ(cylinder->sample({0.1f, 0.1f, 0}, {0.5f, 0.5f}).solidAngle, 0);
    EXPECT_NEAR(cylinder->area(), 2 * kPi * 0.7 * 2.5, 1e-5);
}

TEST(AreaShape, FarAwayAndDegenerate) {
    // A million radii away a rectangle is its area over the squared distance.
    const auto rect = AreaShape::make(light(Light::Type::Rect), lookingDown({0, 0, 1e6}));
    const Measured m = irradiance(*rect, {0, 0, 0}, {0, 0, 1}, 1000);
    EXPECT_NEAR(m.mean, 1.2 / 1e12, 1e-5 * 1.2 / 1e12);
    const auto sphere = AreaShape::make(light(Light::Type::Sphere), lookingDown({0, 0, 1e6}));
    const Measured s = irradiance(*sphere, {0, 0, 0}, {0, 0, 1}, 1000);
    EXPECT_NEAR(s.mean, kPi * 0.49 / 1e12, 1e-4 * kPi * 0.49 / 1e12);
    Light flat = light(Light::Type::Rect);
    flat.width = 0;
    EXPECT_FALSE(AreaShape::make(flat, Transform()));
    flat.width = std::nanf("");
    EXPECT_FALSE(AreaShape::make(flat, Transform()));
    EXPECT_FALSE(AreaShape::make(light(Light::Type::Dome), Transform()));
}

// A ray that finds a point asks for the density that a sample of that point had.
TEST(AreaShape, RaysKnowTheDensityOfSamples) {
    CounterRng rng(5, 1);
    for (const Light::Type type : {Light::Type::Sphere, Light::Type::Disk, Light::Type::Rect, Light::Type::Cylinder}) {
        for (const double height : {1.5, 400.0}) { // far rectangles are sampled by area
            const auto shape = AreaShape::make(light(type), lookingDown({0.4, -0.3, height}));
            ASSERT_TRUE(shape);
            int found = 0;
            for (int i = 0; i < 200; ++i) {
                const float u = rng.uniform(), v = rng.uniform();
                const Vec3f point(0.1f, 0.2f, 0);
                const ShapeSample s = shape->sample(point, {u, v});
                const float t = shape->intersect(point, s.towards);
                if (s.solidAngle > 0 && std::abs(t - s.distance) < 1e-3f * s.distance) {
                    ++found;
                    EXPECT_NEAR(shape->solidAngle(point, s.towards, t), s.solidAngle, 5e-3f * s.solidAngle)
                        << int(type) << " " << height;
                }
            }
            EXPECT_GT(found, 100) << int(type) << " " << height;
        }
    }
}

} // namespace
} // namespace stf::test
