// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_solver.h"

#include "stfLib/base/parallel.h"
#include "stfLib/core/core_walk.h"
#include "tests/unit/core/core_shapes.h"
#include "tests/unit/support/files.h"

#include <cmath>

using namespace stf;
using namespace stf::test;

namespace {

CoreMaterial grey(double sigmaA, double sigmaS) {
    CoreMaterial m;
    m.sigmaA = Vec3d(sigmaA);
    m.sigmaSPrime = Vec3d(sigmaS);
    return m;
}

// What the middle of a plate returns of light on either of its faces, means over the samples there.
struct Plate {
    double reflected = 0, transmitted = 0, scatter = 0; ///< scatter: of T among samples, as a share of it
};
Plate plate(double tau, double absorption, CoreModel model, float width = 20) {
    const CoreShape s = box({width, width, 1}, 1500);
    const CoreResponse k = s.response(grey(tau * absorption, tau * (1 - absorption)), model);
    const std::vector<Vec3f>& at = k.samples().positions;
    std::vector<Rgb> lit(at.size(), Rgb(0.0f));
    for (std::size_t i = 0; i < at.size(); ++i) {
        lit[i] = Rgb(at[i].z > 0.499f ? 1.0f : 0.0f);
    }
    const std::vector<Rgb> out = k.apply(lit);
    Plate p;
    double above = 0, below = 0, squares = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
        if (std::abs(at[i].x) < width / 4 && std::abs(at[i].y) < width / 4) {
            const double area = double(k.samples().areas[i]), b = double(out[i].x);
            if (at[i].z > 0.499f) {
                p.reflected += b * area;
                above += area;
            } else {
                p.transmitted += b * area;
                squares += b * b * area;
                below += area;
            }
        }
    }
    p.reflected /= above;
    p.transmitted /= below;
    p.scatter = std::sqrt(squares / below - p.transmitted * p.transmitted) / p.transmitted;
    return p;
}

TEST(CoreResponse, LightComesThroughAThinPlate) {
    const nlohmann::json data = reference("slab_cases.json");
    for (const auto& c : data["cases"]) {
        if (c["tau"] == 16 && c["g"] == 0) {
            const Plate p = plate(16, 1 - c["albedo"].get<double>(), CoreModel::Auto);
            const double r = c["diffuse"]["R_total"], t = c["diffuse"]["T_total"];
            std::printf("R %+.2f %%, T %+.2f %%, samples differ by %.1f %%\n", 100 * (p.reflected / r - 1),
                        100 * (p.transmitted / t - 1), 100 * p.scatter);
            EXPECT_NEAR(p.reflected, r, 0.01 * r);
            EXPECT_NEAR(p.transmitted, t, 0.03 * t);
            EXPECT_LT(p.scatter, 0.09);
        }
    }
}

TEST(CoreResponse, UniformLightOnThickBodiesReturnsTheAlbedo) {
    // Spread length 0.58 mm; the ball's radius is 8.6 of it, which walks know: in the ball light decays as sinh(k r) /
    // r, by 1 / tanh(k R) - 1 / (k R) as steeply at the surface as in a half-space.
    const CoreMaterial m = grey(0.1, 9.9);
    const double half = Dipole(0.1, 9.9).diffuseAlbedo(), kr = CoreWalk::Diffusion(0.1, 9.9).decay * 5;
    const double slope = (1 - half) / (1 + half) * (1 / std::tanh(kr) - 1 / kr), curved = (1 - slope) / (1 + slope);
    for (CoreModel model : {CoreModel::Auto, CoreModel::Dipole, CoreModel::Walk}) {
        const double exact = model == CoreModel::Walk ? curved : half;
        const CoreShape s = ball(5, 800);
        const CoreResponse k = s.response(m, model);
        const std::vector<Rgb> out = k.apply(std::vector<Rgb>(k.samples().positions.size(), Rgb(1.0f)));
        EXPECT_EQ(k.walkedSamples(), model == CoreModel::Walk ? k.samples().positions.size() : 0u);
        double mean = 0;
        for (const Rgb& b : out) {
            EXPECT_NEAR(b.y / exact, 1, model == CoreModel::Walk ? 0.05 : 1e-5);
            mean += double(b.y) / double(out.size());
        }
        EXPECT_NEAR(mean / exact, 1, 0.004) << int(model);
    }
}

TEST(CoreResponse, WalksAndDipolesAgreeInTheThickLimit) {
    // Half of a large ball is lit: what is beyond the terminator, in the mean over rings.
    const CoreMaterial m = grey(0.05, 5);
    const CoreShape s = ball(12, 4000);
    std::vector<double> beyond[2];
    for (CoreModel model : {CoreModel::Dipole, CoreModel::Walk}) {
        const CoreResponse k = s.response(m, model);
        const std::vector<Vec3f>& at = k.samples().positions;
        std::vector<Rgb> lit;
        for (const Vec3f& p : at) {
            lit.push_back(Rgb(p.z > 0 ? 1.0f : 0.0f));
        }
        const std::vector<Rgb> out = k.apply(lit);
        std::vector<double>& ring = beyond[model == CoreModel::Walk];
        ring.assign(5, 0);
        std::vector<int> count(5, 0);
        for (std::size_t i = 0; i < at.size(); ++i) {
            const int r = int(std::floor((at[i].z + 2.5f) / 1)); // mm, around the terminator
            if (r >= 0 && r < 5) {
                ring[std::size_t(r)] += double(out[i].x);
                ++count[std::size_t(r)];
            }
        }
        for (std::size_t r = 0; r < 5; ++r) {
            ring[r] /= count[r];
        }
    }
    for (std::size_t r = 0; r < 5; ++r) {
        std::printf("%.4f %.4f\n", beyond[0][r], beyond[1][r]);
        EXPECT_NEAR(beyond[1][r], beyond[0][r], 0.04);
    }
}

TEST(CoreResponse, BothSidesLitReturnsWhatTheBodyReturns) {
    // Without absorption all of it, to rounding of the walks' means.
    const CoreShape s = box({10, 10, 2}, 600);
    const CoreResponse k = s.response(grey(0, 2), CoreModel::Auto);
    EXPECT_EQ(k.walkedSamples(), k.samples().positions.size());
    double mean = 0, area = 0;
    const std::vector<Rgb> out = k.apply(std::vector<Rgb>(k.samples().positions.size(), Rgb(1.0f)));
    for (std::size_t i = 0; i < out.size(); ++i) {
        mean += double(out[i].x) * double(k.samples().areas[i]);
        area += double(k.samples().areas[i]);
    }
    EXPECT_NEAR(mean / area, 1, 1e-5);
    EXPECT_LE(k.largestAlbedo(), 1.0001f);
}

TEST(CoreResponse, Reciprocity) {
    // From one end of a bar to the other and back: sum over both of A_i K_ij.
    const CoreShape s = box({3, 3, 8}, 800);
    const CoreResponse k = s.response(grey(0.02, 1.5), CoreModel::Walk);
    const SurfacePoints& p = k.samples();
    double flux[2];
    for (int side = 0; side < 2; ++side) {
        std::vector<Rgb> lit;
        for (const Vec3f& at : p.positions) {
            lit.push_back(Rgb((side ? -at.z : at.z) > 2 ? 1.0f : 0.0f));
        }
        const std::vector<Rgb> out = k.apply(lit);
        flux[side] = 0;
        for (std::size_t i = 0; i < out.size(); ++i) {
            flux[side] += (side ? p.positions[i].z : -p.positions[i].z) > 2 ? double(out[i].x * p.areas[i]) : 0.0;
        }
    }
    EXPECT_GT(flux[0], 0);
    EXPECT_NEAR(flux[1] / flux[0], 1, 0.05);
}

TEST(CoreResponse, OnlyAbsorption) {
    // Nothing returns, 2 E_3(1) = 0.2193839 of it comes through a wide plate.
    CoreMaterial m = grey(1, 0);
    m.sigmaSPrime.y = 1e-9;
    const CoreShape s = box({60, 60, 1}, 3000);
    const CoreResponse k = s.response(m, CoreModel::Auto);
    std::vector<Rgb> lit;
    for (const Vec3f& at : k.samples().positions) {
        lit.push_back(Rgb(at.z > 0.499f ? 1.0f : 0.0f));
    }
    const std::vector<Rgb> out = k.apply(lit);
    double through = 0, back = 0, count = 0;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const Vec3f& at = k.samples().positions[i];
        if (std::abs(at.x) < 20 && std::abs(at.y) < 20) {
            (at.z < 0 ? through : back) += double(out[i].x);
            count += at.z < 0 ? 1 : 0;
        }
    }
    EXPECT_NEAR(through / count, 0.2193839, 0.004);
    EXPECT_LT(back / count, 1e-6);
}

TEST(CoreResponse, StiffMedia) {
    for (double scattering : {1e-4, 1e4}) {
        for (double absorption : {0.0, 1e-7, 0.5}) {
            const CoreShape s = box(Vec3f(10), 400);
            const CoreResponse k =
                s.response(grey(scattering * absorption / (1 - absorption), scattering), CoreModel::Auto);
            for (const Rgb& b : k.apply(std::vector<Rgb>(k.samples().positions.size(), Rgb(1.0f)))) {
                ASSERT_TRUE(isFinite(b));
                ASSERT_GE(b.x, 0);
                ASSERT_LE(b.x, 1.0001f);
            }
        }
    }
}

TEST(CoreResponse, DoesNotDependOnThreadsAndCancels) {
    const CoreShape s = box({6, 6, 1}, 500);
    std::vector<Rgb> results[2];
    for (int threads : {1, 2}) {
        setThreadCount(threads);
        const CoreResponse k = s.response(grey(0.1, 3), CoreModel::Auto);
        results[threads - 1] = k.apply(std::vector<Rgb>(k.samples().positions.size(), Rgb(1.0f)));
    }
    setThreadCount(0);
    EXPECT_EQ(results[0], results[1]);
    Progress progress;
    progress.cancel();
    EXPECT_THROW(CoreResponse(grey(0.1, 3), {s.points, s.triangles, s.normals, *s.mesh, s.samples, 1.0},
                              CoreModel::Auto, 1, progress),
                 Cancelled);
}

TEST(CoreResponse, InterpolatedExitanceIsThatOfTheFullSum) {
    // Samples half a spread length apart, lit on one side with a sharp terminator; elsewhere summed from all samples.
    const CoreShape s = ball(8, 2000);
    Progress progress;
    auto k = std::make_shared<const CoreResponse>(s.response(grey(0.05, 4), CoreModel::Dipole));
    const SurfacePoints& p = k->samples();
    CoreLight light(p.positions.size());
    for (std::size_t i = 0; i < p.positions.size(); ++i) {
        light.diffuse[i] = Rgb(p.positions[i].z > 0 ? 1.0f : 0.0f);
        light.shellReflectance[i] = Rgb(0.4f);
    }
    CoreSolver solver(k, light);
    solver.solve(progress);
    const float spacing = std::sqrt(4 * 3.14159265f * 64 / float(p.positions.size()));
    EXPECT_NEAR(double(spacing), 0.5 * CoreResponse::spreadLength(0.05, 4), 0.1);
    const std::vector<Rgb> told = SampleFilter(p, s.points, s.normals, {1.8f * spacing}).apply(solver.exitance());
    double worst = 0, squares = 0, largest = 0;
    for (std::size_t i = 0; i < s.points.size(); i += 7) {
        const double full = double(solver.dipoleExitance(s.points[i], 0).x), off = double(told[i].x) - full;
        worst = std::max(worst, std::abs(off));
        squares += off * off;
        largest = std::max(largest, full);
    }
    const double rms = std::sqrt(squares / double(s.points.size() / 7));
    std::printf("worst %.2g, rms %.2g of the largest\n", worst / largest, rms / largest);
    EXPECT_LT(worst, 0.12 * largest) << "at the terminator";
    EXPECT_LT(rms, 0.02 * largest);
}

TEST(CoreResponse, AnOpenSheetIsAHalfSpace) {
    CoreShape s;
    s.points = {{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}};
    s.triangles = {{0, 1, 2}, {0, 2, 3}};
    s.normals.assign(4, Vec3f(0, 0, 1));
    s.finish(200);
    const CoreResponse k = s.response(grey(0.1, 3), CoreModel::Auto);
    EXPECT_EQ(k.walkedSamples(), 0u);
    EXPECT_NEAR(k.apply(std::vector<Rgb>(k.samples().positions.size(), Rgb(1.0f)))[7].x, Dipole(0.1, 3).diffuseAlbedo(),
                1e-5);
}

} // namespace
