// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/dipole.h"

#include "tests/unit/support/files.h"

#include <cmath>

using namespace stf;
using namespace stf::test;

namespace {

constexpr double kPi = 3.14159265358979323846;

// INT 2 pi r kernel(r^2) dr from 0 to the radius, steps growing with r.
double quadrature(const Dipole& d, double radius) {
    const int n = 20000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double u = (i + 0.5) / n, r = radius * u * u * u, step = 3 * radius * u * u / n;
        sum += 2 * kPi * r * double(d.kernel(float(r * r))) * step;
    }
    return sum;
}

TEST(Dipole, DiscAndPlaneIntegralsAreThoseOfTheKernel) {
    for (double sigmaA : {0.0, 0.002, 0.5}) {
        for (double sigmaS : {0.3, 2.5, 40.0}) {
            const Dipole d(sigmaA, sigmaS);
            for (double radius : {0.01, 0.3, 5.0, 100.0}) {
                EXPECT_NEAR(quadrature(d, radius) / d.discIntegral(radius), 1, 1e-5)
                    << sigmaA << ", " << sigmaS << ", " << radius;
            }
            EXPECT_NEAR(d.discIntegral(1e7) / d.planeIntegral(), 1, 1e-5);
        }
    }
}

TEST(Dipole, TotalIsThatOfJensen) {
    // R_d = a' / 2 (1 + exp(-4/3 A s)) exp(-s), s = sqrt(3 (1 - a')), A = 1 (Jensen et al. 2001).
    for (double albedo : {0.3, 0.8, 0.99, 1.0}) {
        const double s = std::sqrt(3 * (1 - albedo));
        const double expected = 0.5 * albedo * (1 + std::exp(-4.0 / 3 * s)) * std::exp(-s);
        EXPECT_NEAR(Dipole(2 * (1 - albedo), 2 * albedo).planeIntegral() / expected, 1, 1e-6) << albedo;
    }
}

TEST(Dipole, AlbedosAreExact) {
    const nlohmann::json data = reference("hfunc.json");
    for (const auto& [text, row] : data["table"].items()) {
        const double albedo = std::stod(text);
        for (double scale : {1e-3, 1.0, 1e3}) { // the unit of length does not matter
            const Dipole d((1 - albedo) * scale, albedo * scale);
            EXPECT_NEAR(d.diffuseAlbedo(), row["R_sph"].get<double>(), 1e-6) << text;
            for (std::size_t i = 0; i < data["mu"].size(); ++i) {
                EXPECT_NEAR(d.directAlbedo(std::stod(data["mu"][i].get<std::string>())),
                            row["R_plane"][i].get<double>(), 1e-6);
            }
        }
    }
}

TEST(Dipole, WithoutAbsorptionEverythingReturnsAndTheTailIsCubic) {
    const Dipole d(0, 2);
    EXPECT_EQ(d.diffuseAlbedo(), 1);
    EXPECT_TRUE(std::isinf(d.diffusionLength()));
    EXPECT_NEAR(d.planeIntegral(), 1, 1e-6);
    // Both poles: a' / (4 pi) (z_r + z_v) / r^3.
    const double r = 1000, expected = (0.5 + 0.5 * 7 / 3) / (4 * kPi * r * r * r);
    EXPECT_NEAR(double(d.kernel(float(r * r))) / expected, 1, 1e-5);
}

TEST(Dipole, WithoutScatteringNothingReturns) {
    for (double sigmaA : {0.0, 1.0, 1e6}) {
        const Dipole d(sigmaA, 0);
        EXPECT_EQ(d.kernel(0), 0);
        EXPECT_EQ(d.tabulated(1), 0);
        EXPECT_EQ(d.discIntegral(1), 0);
        EXPECT_EQ(d.planeIntegral(), 0);
        EXPECT_EQ(d.diffuseAlbedo(), 0);
        EXPECT_EQ(d.directAlbedo(0.5), 0);
    }
}

TEST(Dipole, FiniteFromTheOriginToFarAway) {
    for (double sigmaA : {0.0, 1e-6, 0.01, 10.0}) {
        for (double sigmaS : {1e-3, 1.0, 1e3}) {
            const Dipole d(sigmaA, sigmaS);
            const double reach = sigmaA > 0 ? d.diffusionLength() : 1 / sigmaS;
            float last = d.kernel(0);
            EXPECT_GT(last, 0);
            for (double x = 1e-6; x <= 1e4; x *= 1.5) {
                const float r = float(x * reach);
                for (float k : {d.kernel(r * r), d.tabulated(r * r)}) {
                    ASSERT_TRUE(std::isfinite(k)) << sigmaA << ", " << sigmaS << ", " << r;
                    ASSERT_GE(k, 0);
                }
                ASSERT_LE(d.kernel(r * r), last * 1.00001f) << "falls with distance";
                last = d.kernel(r * r);
            }
            if (sigmaA > 0) {
                EXPECT_EQ(last, 0) << "10000 diffusion lengths away";
            }
        }
    }
}

TEST(Dipole, TableFollowsTheKernel) {
    // Within 0.3 % down to a ten thousandth of the peak, and close as long as anything is left.
    for (double sigmaA : {0.0, 0.004, 0.5}) {
        for (double sigmaS : {0.5, 2.6, 20.0}) {
            const Dipole d(sigmaA, sigmaS);
            for (float r2 = 1e-8f; r2 < 1e8f; r2 *= 1.003f) {
                const float k = d.kernel(r2), peak = d.kernel(0);
                if (k > 1e-12f * peak) {
                    ASSERT_NEAR(d.tabulated(r2) / k, 1, k > 1e-4f * peak ? 3e-3f : 2e-2f)
                        << sigmaA << ", " << sigmaS << ", r2 " << r2;
                }
            }
        }
    }
}

TEST(Dipole, DiffusionLength) {
    const Dipole d(0.1, 0.9);
    EXPECT_NEAR(d.diffusionLength(), 1 / std::sqrt(0.3), 1e-6);
}

} // namespace
