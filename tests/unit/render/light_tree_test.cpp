// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_set.h"

#include "stfLib/base/random.h"

#include <cmath>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

std::map<std::string, Light> spheres(int n, std::uint64_t seed) {
    std::map<std::string, Light> lights;
    CounterRng rng(seed, 1);
    for (int i = 0; i < n; ++i) {
        Light l;
        l.type = Light::Type::Sphere;
        l.radius = 0.05f;
        l.emission = Rgb(0.2f + rng.uniform());
        l.lightToWorld.translation = {10 * double(rng.uniform()) - 5, 10 * double(rng.uniform()) - 5,
                                      0.5 + 4 * double(rng.uniform())};
        lights["/l" + std::to_string(i)] = l;
    }
    return lights;
}

double exact(const LightSet& lights, const Vec3f& point, const Vec3f& normal) {
    double sum = 0;
    for (std::size_t l = 0; l < lights.count(); ++l) {
        for (int i = 0; i < 16; ++i) {
            const LightSample s =
                lights.sample(l, point, normal, {(float(i % 4) + 0.5f) / 4, (float(i / 4) + 0.5f) / 4});
            sum += double(s.irradiance.y) * std::max(0.0, double(dot(s.towards, normal))) / 16;
        }
    }
    return sum;
}

struct Measured {
    double mean, error;
};
Measured chosen(const LightSet& lights, const Vec3f& point, const Vec3f& normal, int most, int n = 20000) {
    CounterRng rng(9, 1);
    double sum = 0, squares = 0;
    for (int i = 0; i < n; ++i) {
        LightPick picks[32];
        const int count = lights.choose(point, normal, rng.uniform(), most, picks);
        EXPECT_LE(count, most);
        double e = 0;
        for (int p = 0; p < count; ++p) {
            const LightSample s = lights.sample(picks[p].light, point, normal, {rng.uniform(), rng.uniform()});
            e += double(s.irradiance.y) * double(picks[p].weight) * std::max(0.0, double(dot(s.towards, normal)));
        }
        sum += e / n;
        squares += e * e / n;
    }
    return {sum, std::sqrt((squares - sum * sum) / n)};
}

TEST(LightTree, ChoosingIsUnbiased) {
    std::map<std::string, Light> all = spheres(200, 3);
    const Vec3f up{0, 0, 1}, tilted = normalize(Vec3f(0.5f, -0.4f, 0.8f));
    for (const Vec3f& n : {up, tilted}) {
        for (const Vec3f& p : {Vec3f(0, 0, 0), Vec3f(4, -3, 1)}) {
            const LightSet lights(all, {});
            const Measured m = chosen(lights, p, n, 4);
            EXPECT_NEAR(m.mean, exact(lights, p, n), 4 * m.error);
        }
    }
    // With many distant lights beside them: both kinds take part.
    for (int i = 0; i < 6; ++i) {
        Light l;
        l.emission = Rgb(0.01f * float(i + 1));
        all["/far" + std::to_string(i)] = l;
    }
    const LightSet lights(all, {});
    const Measured m = chosen(lights, {0, 0, 0}, up, 4);
    EXPECT_NEAR(m.mean, exact(lights, {0, 0, 0}, up), 4 * m.error);
    const Measured many = chosen(lights, {0, 0, 0}, up, 32, 4000);
    EXPECT_NEAR(many.mean, exact(lights, {0, 0, 0}, up), 4 * many.error);
}

// Chances of all lights sum to one, and each is what choosing it comes with, above and below the horizon.
TEST(LightTree, TellsTheChanceOfEachLight) {
    std::vector<TreeLight> lights;
    CounterRng rng(4, 2);
    for (std::size_t i = 0; i < 37; ++i) {
        TreeLight l;
        const Vec3f at{4 * rng.uniform() - 2, 4 * rng.uniform() - 2, 4 * rng.uniform() - 2};
        l.bounds.add(at);
        l.bounds.add(at + Vec3f(0.2f));
        l.power = i == 5 ? 0.0f : rng.uniform();
        l.index = 36 - i;
        lights.push_back(l);
    }
    const LightTree tree(lights);
    const Vec3f point(0.1f, -0.3f, 0.2f), normal(0, 0.6f, 0.8f);
    double sum = 0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        sum += double(tree.chance(point, normal, i));
    }
    EXPECT_NEAR(sum, 1, 1e-5);
    for (int k = 0; k < 1000; ++k) {
        const LightTree::Choice c = tree.choose(point, normal, (float(k) + 0.5f) / 1000);
        EXPECT_NEAR(tree.chance(point, normal, c.index), c.chance, 1e-6f + 1e-5f * c.chance);
    }
}

TEST(LightTree, IsBetterThanChance) {
    const LightSet lights(spheres(500, 4), {});
    const Vec3f up{0, 0, 1};
    const Measured m = chosen(lights, {1, 1, 0}, up, 4, 4000);
    // By chance, with the same number of picks: the scatter of one light's share.
    CounterRng rng(5, 2);
    double sum = 0, squares = 0;
    constexpr int n = 4000;
    for (int i = 0; i < n; ++i) {
        double e = 0;
        for (int k = 0; k < 4; ++k) {
            const std::size_t l = std::size_t(rng.uniform() * 500);
            const LightSample s = lights.sample(l, {1, 1, 0}, up, {rng.uniform(), rng.uniform()});
            e += double(s.irradiance.y) * 125 * std::max(0.0, double(dot(s.towards, up)));
        }
        sum += e / n;
        squares += e * e / n;
    }
    EXPECT_LT(m.error, 0.5 * std::sqrt((squares - sum * sum) / n));
}

TEST(LightTree, MirroredRaysFindTheirLights) {
    const std::map<std::string, Light> all = spheres(100, 6);
    LightSet lights(all, {});
    const Vec3d origin(1, 2, 3);
    lights.place(origin);
    for (const auto& [id, l] : all) {
        const Vec3f to(l.lightToWorld.translation - origin);
        EXPECT_GE(lights.mirrored({0, 0, 0}, normalize(to), 0, 1e9f).y, l.emission.y) << id;
        EXPECT_EQ(lights.mirrored({0, 0, 0}, normalize(to), 0, 1e-3f).y, 0);
    }
    EXPECT_EQ(lights.mirrored({0, 0, 100}, {0, 0, 1}, 0, 1e9f).y, 0);
}

TEST(LightTree, NormalizedLightsKeepTheirPower) {
    Light l;
    l.type = Light::Type::Sphere;
    l.emission = Rgb(3.0f);
    l.normalize = true;
    l.lightToWorld.translation = {0, 0, 50};
    for (float radius : {0.01f, 1.0f, 4.0f}) {
        l.radius = radius;
        const LightSet lights({{"/l", l}}, {});
        // radiance 3 / (4 pi r^2) over pi r^2 / d^2.
        EXPECT_NEAR(exact(lights, {0, 0, 0}, {0, 0, 1}), 3.0 / 4 / 2500, 1e-4 * 3.0 / 4 / 2500);
    }
}

} // namespace
} // namespace stf::test
