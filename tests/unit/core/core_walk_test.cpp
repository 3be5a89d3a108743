// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_walk.h"

#include "tests/unit/core/core_shapes.h"
#include "tests/unit/support/files.h"

#include <cmath>

using namespace stf;
using namespace stf::test;

namespace {

struct Mean {
    double value = 0, error = 0;
};

// What leaves a shape where `counts` says so, of light that enters at a point.
template<class Counts>
Mean leaving(const CoreShape& s, const CoreMaterial& m, const Vec3f& from, const Vec3f& inward, int walks,
             Counts&& counts, int channel = 0) {
    const CoreWalk walk(m, *s.mesh, 1);
    Ray ray;
    ray.origin = from - inward;
    ray.direction = inward;
    RayHit hit;
    EXPECT_TRUE(s.mesh->intersect(ray, hit, 2));
    double sum = 0, squares = 0;
    for (int i = 0; i < walks; ++i) {
        for (const CoreWalk::Group& g : walk.groups()) {
            if (!g.channel[channel]) {
                continue;
            }
            CounterRng rng(7, std::uint64_t(i));
            const CoreWalk::Exit e = walk.walk(g, from, inward, hit.triangle, rng);
            const double w = e.left && counts(e.point) ? double(e.weight[channel]) : 0.0;
            sum += w;
            squares += w * w;
        }
    }
    const double mean = sum / walks;
    return {mean, std::sqrt(std::max(0.0, squares / walks - mean * mean) / walks)};
}

CoreMaterial grey(double sigmaA, double sigmaS) {
    CoreMaterial m;
    m.sigmaA = Vec3d(sigmaA);
    m.sigmaSPrime = Vec3d(sigmaS);
    return m;
}

const auto everywhere = [](const Vec3f&) { return true; };

// A flat slab of thickness 1: shares that leave through the face of entrance and the other.
void slab(double tau, double absorption, int walks, Mean& back, Mean& through) {
    const CoreShape s = box({40, 40, 1});
    const CoreMaterial m = grey(tau * absorption, tau * (1 - absorption));
    back = leaving(s, m, {0.1f, 0.2f, 0.5f}, {0, 0, -1}, walks, [](const Vec3f& p) { return p.z > 0.49f; });
    through = leaving(s, m, {0.1f, 0.2f, 0.5f}, {0, 0, -1}, walks, [](const Vec3f& p) { return p.z < -0.49f; });
}

// The same by a walk in one dimension that knows depths and cosines only.
void plainSlab(double tau, double absorption, int walks, Mean& back, Mean& through) {
    double sum[2] = {0, 0}, squares[2] = {0, 0};
    for (int i = 0; i < walks; ++i) {
        CounterRng rng(11, std::uint64_t(i));
        double depth = 0, mu = std::sqrt(double(rng.uniformPositive())), weight = 1;
        for (;;) {
            depth += mu * double(rng.exponential());
            if (depth < 0 || depth > tau) {
                sum[depth > tau] += weight;
                squares[depth > tau] += weight * weight;
                break;
            }
            weight *= 1 - absorption;
            if (weight < 0.01) {
                if (rng.uniform() < 0.5f) {
                    break;
                }
                weight *= 2;
            }
            mu = 2 * double(rng.uniform()) - 1;
        }
    }
    const auto mean = [&](int k) {
        return Mean{sum[k] / walks, std::sqrt((squares[k] / walks - std::pow(sum[k] / walks, 2)) / walks)};
    };
    back = mean(0);
    through = mean(1);
}

TEST(CoreWalk, SlabsOfAddingDoubling) {
    const nlohmann::json data = reference("slab_cases.json");
    int known = 0;
    for (const auto& c : data["cases"]) {
        if (c["g"].get<double>() != 0 || c["n"].get<double>() != 1 || c["tau"].get<double>() > 100) {
            continue;
        }
        ++known;
        Mean back, through;
        slab(c["tau"], 1 - c["albedo"].get<double>(), 60000, back, through);
        const double r = c["diffuse"]["R_total"], t = c["diffuse"]["T_total"];
        EXPECT_NEAR(back.value, r, 4 * back.error + 0.002 * r) << c["tau"];
        EXPECT_NEAR(through.value, t, 4 * through.error + 0.002 * t) << c["tau"];
    }
    EXPECT_GE(known, 2);
}

TEST(CoreWalk, SlabsOfAPlainWalk) {
    struct Case {
        double tau, absorption;
    };
    // Thin to thick; with 25 and 60 mean free paths most of the way is jumps.
    for (const Case& c : {Case{1, 0.1}, Case{4, 0.5}, Case{6, 0.01}, Case{12, 0.02}, Case{25, 0.001}, Case{60, 1e-4}}) {
        Mean back, through, plainBack, plainThrough;
        slab(c.tau, c.absorption, 60000, back, through);
        plainSlab(c.tau, c.absorption, 200000, plainBack, plainThrough);
        std::printf("tau %g: R %+.2f +- %.2f %%, T %+.2f +- %.2f %%\n", c.tau, 100 * (back.value / plainBack.value - 1),
                    100 * std::hypot(back.error, plainBack.error) / plainBack.value,
                    100 * (through.value / plainThrough.value - 1),
                    100 * std::hypot(through.error, plainThrough.error) / plainThrough.value);
        EXPECT_NEAR(back.value, plainBack.value, 4 * std::hypot(back.error, plainBack.error) + 0.005 * plainBack.value);
        EXPECT_NEAR(through.value, plainThrough.value,
                    4 * std::hypot(through.error, plainThrough.error) + 0.005 * plainThrough.value);
    }
}

TEST(CoreWalk, BlackMediumLetsThroughTwoE3) {
    // 2 E_3(1) = 0.2193839 (Abramowitz & Stegun, table 5.1: E_3(1) = 0.1096920).
    const CoreShape s = box({400, 400, 1});
    const Mean t = leaving(s, grey(1, 0), {0, 0, 0.5f}, {0, 0, -1}, 100000, everywhere);
    EXPECT_NEAR(t.value, 0.2193839, 4 * t.error);
    const Mean vacuum = leaving(s, grey(0, 0), {0, 0, 0.5f}, {0, 0, -1}, 1000, everywhere);
    EXPECT_EQ(vacuum.value, 1);
}

TEST(CoreWalk, NothingIsLostWithoutAbsorption) {
    for (double scattering : {1e-4, 0.1, 1.0, 30.0, 1e4}) { // 1/mm, of 10 mm
        for (const CoreShape& s : {box(Vec3f(10)), ball(5)}) {
            // The middle of a triangle.
            const Vec3i t = s.triangles[s.triangles.size() / 3];
            const Vec3f a = s.points[std::size_t(t.x)], b = s.points[std::size_t(t.y)], c = s.points[std::size_t(t.z)];
            const Mean all =
                leaving(s, grey(0, scattering), (a + b + c) / 3.0f, -normalize(cross(b - a, c - a)), 2000, everywhere);
            EXPECT_NEAR(all.value, 1, 1e-5) << scattering;
        }
    }
}

TEST(CoreWalk, StiffMediaReturnTheAlbedoOfAHalfSpace) {
    const CoreShape s = box(Vec3f(10));
    for (double absorption : {1e-7, 1e-3, 0.05, 0.5}) {
        const double sigma = 1e4;
        const Mean r =
            leaving(s, grey(sigma * absorption, sigma * (1 - absorption)), {1, 2, 5}, {0, 0, -1}, 20000, everywhere);
        const double exact = Dipole(absorption, 1 - absorption).diffuseAlbedo();
        EXPECT_NEAR(r.value, exact, 4 * r.error + 0.003 * exact) << absorption;
    }
}

TEST(CoreWalk, SurvivalIsThatOfAWalk) {
    // From the middle of a ball, walked step by step (a ball below the radius of jumps, or unit steps by hand).
    for (double absorption : {0.001, 0.005, 0.02}) {
        const double radius = 8;
        double sum = 0, squares = 0;
        constexpr int kWalks = 100000;
        for (int i = 0; i < kWalks; ++i) {
            CounterRng rng(5, std::uint64_t(i));
            Vec3d p(0.0);
            double weight = 1;
            for (;;) {
                const double z = 2 * double(rng.uniform()) - 1, phi = 6.283185307 * double(rng.uniform()),
                             r = std::sqrt(1 - z * z);
                const Vec3d d(r * std::cos(phi), r * std::sin(phi), z);
                p += d * double(rng.exponential());
                if (dot(p, p) > radius * radius) {
                    break;
                }
                weight *= 1 - absorption;
            }
            sum += weight;
            squares += weight * weight;
        }
        const double mean = sum / kWalks, error = std::sqrt((squares / kWalks - mean * mean) / kWalks);
        const double told = CoreWalk::Diffusion(absorption, 1 - absorption).survival(radius);
        EXPECT_NEAR(told, mean, 4 * error + 0.005 * mean) << absorption;
    }
    EXPECT_EQ(CoreWalk::Diffusion(0, 1).survival(1e9), 1);
    EXPECT_EQ(CoreWalk::Diffusion(1, 1).survival(1e9), 0);
    EXPECT_NEAR(CoreWalk::Diffusion(1e-12, 1).survival(1000), 1 - 3e-12 * 1e6 / 6, 1e-8);
}

TEST(CoreWalk, DecayIsThatOfTransportTheory) {
    // Case, de Hoffmann & Placzek 1953: albedo 0.9: 0.525430, albedo 0.5: 0.957504.
    EXPECT_NEAR(CoreWalk::Diffusion(0.1, 0.9).decay, 0.525430, 1e-5);
    EXPECT_NEAR(CoreWalk::Diffusion(0.5, 0.5).decay, 0.957504, 1e-5);
    EXPECT_NEAR(CoreWalk::Diffusion(1e-9, 1).decay / std::sqrt(3e-9), 1, 1e-6);
    EXPECT_NEAR(CoreWalk::Diffusion(0, 1).decay, 0, 1e-12);
}

TEST(CoreWalk, ChannelsThatScatterAlikeWalkTogether) {
    CoreMaterial m;
    m.sigmaA = {0.002, 0.004, 0.3};
    m.sigmaSPrime = {2.2, 2.6, 9.0};
    const CoreShape s = box({30, 30, 4});
    const CoreWalk walk(m, *s.mesh, 1);
    ASSERT_EQ(walk.groups().size(), 2u);
    // A channel that walks beside another has the mean it has alone.
    for (int c = 0; c < 2; ++c) {
        const auto far = [](const Vec3f& p) { return p.z < 0; };
        const Mean together = leaving(s, m, {0, 0, 2}, {0, 0, -1}, 100000, far, c);
        const Mean alone = leaving(s, grey(m.sigmaA[c], m.sigmaSPrime[c]), {0, 0, 2}, {0, 0, -1}, 100000, far);
        EXPECT_NEAR(together.value, alone.value, 4 * std::hypot(together.error, alone.error)) << c;
    }
}

TEST(CoreWalk, AHoleLosesLightAndEnds) {
    CoreShape s;
    s.points = {{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}};
    s.triangles = {{0, 1, 2}, {0, 2, 3}};
    s.normals.assign(4, Vec3f(0, 0, 1));
    s.finish(0);
    for (double scattering : {0.0, 1e-3, 1.0, 1e3}) {
        const Mean all = leaving(s, grey(0.01, scattering), {0, 0, 0}, {0, 0, -1}, 1000, everywhere);
        EXPECT_GE(all.value, 0);
        EXPECT_LE(all.value, 1);
    }
}

TEST(DistanceCells, NeverMoreThanTheDistance) {
    const CoreShape s = ball(5);
    const DistanceCells cells(*s.mesh);
    CounterRng rng(1, 1);
    double slack = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3f p = (Vec3f(rng.uniform(), rng.uniform(), rng.uniform()) * 2.0f - Vec3f(1.0f)) * 5.5f;
        const float exact = s.mesh->innerDistance(p, 100);
        // The facets of the ball lie within it by up to 5 (1 - cos(pi / 96)).
        EXPECT_NEAR(exact, std::abs(length(p) - 5), 0.02f);
        EXPECT_LE(cells.atLeast(p), exact + 1e-5f);
        slack = std::max(slack, std::abs(p.x) < 5 && std::abs(p.y) < 5 && std::abs(p.z) < 5
                                    ? double(exact - cells.atLeast(p))
                                    : 0.0);
    }
    EXPECT_LT(slack, 1.8 * double(cells.cell()));
}

} // namespace
