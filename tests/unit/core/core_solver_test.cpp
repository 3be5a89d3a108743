// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_solver.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"

#include <gtest/gtest.h>

using namespace stf;

namespace {

constexpr float kPi = 3.14159265358979f;

CoreMaterial material() {
    CoreMaterial m;
    m.sigmaA = {0.01, 0.1, 1.0};
    m.sigmaSPrime = {2.0, 1.5, 1.0};
    return m;
}

// Samples and their light.
struct Lit : SurfacePoints, CoreLight {};

void addSample(Lit& s, const Vec3f& p, float area) {
    s.positions.push_back(p);
    s.areas.push_back(area);
    s.diffuse.push_back(Rgb(0.0f));
    s.direct.push_back(Rgb(0.0f));
    s.shellReflectance.push_back(Rgb(0.0f));
}

Lit sphere(float radius, int count) {
    Lit s;
    for (int i = 0; i < count; ++i) { // Fibonacci points
        const float z = 1 - (2 * float(i) + 1) / float(count), phi = 2.39996323f * float(i), r = std::sqrt(1 - z * z);
        addSample(s, Vec3f(r * std::cos(phi), r * std::sin(phi), z) * radius, 4 * kPi * radius * radius / float(count));
    }
    return s;
}

Lit plane(int n, float spacing) {
    Lit s;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            addSample(s, Vec3f(float(x - n / 2), float(y - n / 2), 0) * spacing, spacing * spacing);
        }
    }
    return s;
}

void light(Lit& s, const Rgb& diffuse, const Rgb& direct, const Rgb& shell) {
    for (std::size_t i = 0; i < s.positions.size(); ++i) {
        s.diffuse[i] = diffuse;
        s.direct[i] = direct;
        s.shellReflectance[i] = shell;
    }
}

CoreSolver solved(const Lit& s, const CoreMaterial& m = material()) {
    CoreSolver solver(std::make_shared<const CoreResponse>(m, s), s);
    Progress progress;
    solver.solve(progress);
    return solver;
}

float albedo(const CoreMaterial& m, int c) {
    return float(Dipole(m.sigmaA[c], m.sigmaSPrime[c]).diffuseAlbedo());
}

TEST(CoreSolver, UniformLightUnderABlackShellReturnsTheAlbedo) {
    for (Lit s : {sphere(5, 500), plane(20, 1)}) {
        light(s, {1, 2, 3}, {0.5f, 0, 1}, Rgb(0.0f));
        const CoreSolver solver = solved(s);
        for (const Vec3f& p : {s.positions[0], s.positions[123], Vec3f(0.1f, 0.2f, 0), Vec3f(3, -4, 20)}) {
            const Rgb b = solver.dipoleExitance(p);
            for (int c = 0; c < 3; ++c) {
                const float e = s.diffuse[0][c] + s.direct[0][c];
                EXPECT_NEAR(b[c] / (albedo(material(), c) * e), 1, 2e-6f) << c;
            }
        }
    }
}

TEST(CoreSolver, UniformShellReflectanceIsAGeometricSeries) {
    for (float r : {0.1f, 0.5f, 0.9f}) {
        for (Lit s : {sphere(5, 500), plane(20, 1)}) {
            light(s, Rgb(1.0f), Rgb(0.0f), Rgb(r));
            const CoreSolver solver = solved(s);
            for (int c = 0; c < 3; ++c) {
                const float a = albedo(material(), c), expected = a / (1 - r * a);
                EXPECT_NEAR(solver.dipoleExitance(s.positions[7])[c] / expected, 1, 1e-3f)
                    << "r " << r << ", channel " << c;
            }
            EXPECT_LT(solver.iterations(), 100);
        }
    }
}

TEST(CoreSolver, LinearInItsLight) {
    Lit a = sphere(5, 400), b = a, sum = a;
    CounterRng rng(3, 0);
    for (std::size_t i = 0; i < a.positions.size(); ++i) {
        const Rgb shell(rng.uniform() * 0.5f);
        a.shellReflectance[i] = b.shellReflectance[i] = sum.shellReflectance[i] = shell;
        a.diffuse[i] = {rng.uniform(), rng.uniform(), rng.uniform()};
        b.direct[i] = {rng.uniform(), rng.uniform(), rng.uniform()};
        sum.diffuse[i] = a.diffuse[i] * 3.0f;
        sum.direct[i] = b.direct[i] * 2.0f;
    }
    const CoreSolver sa = solved(a), sb = solved(b), ss = solved(sum);
    for (std::size_t i = 0; i < 400; i += 50) {
        const Rgb x = sa.dipoleExitance(a.positions[i]) * 3.0f + sb.dipoleExitance(a.positions[i]) * 2.0f;
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(ss.dipoleExitance(a.positions[i])[c] / x[c], 1, 1.5e-3f); // each within 0.1 %
        }
    }
    Lit bright = a;
    for (Rgb& e : bright.diffuse) {
        e *= 0x1p40f;
    }
    EXPECT_EQ(solved(bright).dipoleExitance(a.positions[0]), sa.dipoleExitance(a.positions[0]) * 0x1p40f);
}

TEST(CoreSolver, OneLitSampleSpreadsAsTheDipole) {
    Lit s = plane(41, 0.25f);
    const std::size_t centre = 20 + 41 * 20;
    s.diffuse[centre] = Rgb(1.0f);
    const CoreSolver solver = solved(s);
    for (float r : {0.75f, 1.5f, 2.25f}) { // well inside a patch that ends at 5 mm
        const Rgb b = solver.dipoleExitance({r, 0, 0}, 0);
        for (int c = 1; c < 3; ++c) { // the light of the first channel would reach the patch's edge
            const Dipole d(material().sigmaA[c], material().sigmaSPrime[c]);
            const double expected = d.diffuseAlbedo() * double(d.kernel(r * r)) * 0.0625 / d.planeIntegral();
            EXPECT_NEAR(double(b[c]) / expected, 1, 0.05) << c << " at " << r;
        }
    }
}

TEST(CoreSolver, ClustersStandForTheirSamples) {
    Lit s = sphere(5, 900);
    for (std::size_t i = 0; i < s.positions.size(); ++i) {
        s.diffuse[i] = Rgb(std::max(0.0f, s.positions[i].z)); // light from one side
    }
    const CoreSolver solver = solved(s);
    float largest = 0;
    for (std::size_t i = 0; i < 900; i += 10) {
        largest = std::max(largest, solver.dipoleExitance(s.positions[i], 0).x);
    }
    for (std::size_t i = 0; i < 900; i += 10) {
        const Rgb exact = solver.dipoleExitance(s.positions[i], 0), fast = solver.dipoleExitance(s.positions[i]);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(fast[c], exact[c], 0.01f * largest);
        }
    }
}

TEST(CoreSolver, BlackCoreAndBlackChannel) {
    Lit s = plane(8, 1);
    light(s, Rgb(1.0f), Rgb(1.0f), Rgb(0.9f));
    CoreMaterial m;
    m.sigmaA = {1, 1, 1};
    EXPECT_FALSE(m.scatters());
    EXPECT_EQ(solved(s, m).dipoleExitance({0, 0, 0}), Rgb(0.0f));
    m.sigmaSPrime.y = 1;
    EXPECT_TRUE(m.scatters());
    const Rgb b = solved(s, m).dipoleExitance({0, 0, 0});
    EXPECT_EQ(b.x, 0);
    EXPECT_GT(b.y, 0.1f);
    EXPECT_EQ(b.z, 0);
    EXPECT_EQ(solved(s, CoreMaterial()).dipoleExitance({0, 0, 0}), Rgb(0.0f));
}

TEST(CoreSolver, OneSampleAndNone) {
    Lit one;
    addSample(one, {1, 2, 3}, 4);
    light(one, Rgb(2.0f), Rgb(0.0f), Rgb(0.0f));
    const CoreSolver solver = solved(one);
    EXPECT_NEAR(solver.dipoleExitance({1, 2, 3}).x / (2 * albedo(material(), 0)), 1, 1e-5f);
    EXPECT_TRUE(isFinite(solver.dipoleExitance({1000, 0, 0})));
    EXPECT_EQ(solved(Lit()).dipoleExitance({0, 0, 0}), Rgb(0.0f));
}

TEST(CoreSolver, DarkSamples) {
    EXPECT_EQ(solved(sphere(5, 100)).dipoleExitance({0, 0, 5}), Rgb(0.0f));
}

TEST(CoreSolver, WithoutAbsorptionItEnds) {
    CoreMaterial m;
    m.sigmaSPrime = {1, 1, 1};
    Lit s = sphere(3, 200);
    light(s, Rgb(1.0f), Rgb(0.0f), Rgb(0.8f));
    EXPECT_NEAR(solved(s, m).dipoleExitance(s.positions[3]).x, 5, 0.005f);
    light(s, Rgb(1.0f), Rgb(0.0f), Rgb(1.0f)); // no light can leave: whatever comes out is finite
    EXPECT_TRUE(isFinite(solved(s, m).dipoleExitance(s.positions[3])));
}

TEST(CoreSolver, DoesNotDependOnThreads) {
    Lit s = sphere(5, 300);
    CounterRng rng(4, 0);
    for (std::size_t i = 0; i < 300; ++i) {
        s.diffuse[i] = Rgb(rng.uniform());
        s.shellReflectance[i] = Rgb(rng.uniform());
    }
    setThreadCount(1);
    const Rgb one = solved(s).dipoleExitance({5, 0, 0});
    setThreadCount(2);
    const Rgb two = solved(s).dipoleExitance({5, 0, 0});
    setThreadCount(0);
    EXPECT_EQ(one, two);
}

TEST(CoreSolver, CancelThrows) {
    const Lit s = sphere(5, 100);
    CoreSolver solver(std::make_shared<const CoreResponse>(material(), s), s);
    Progress progress;
    progress.cancel();
    EXPECT_THROW(solver.solve(progress), Cancelled);
}

} // namespace
