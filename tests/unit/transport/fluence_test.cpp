// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/precompute.h"

#include "tests/unit/support/files.h"
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

StfTable table(const BaseVolume& v, std::uint64_t seed, std::uint64_t photons, int polars = 1) {
    TransportOptions options;
    options.seed = seed;
    options.quality = 1e-6f; // as many photons as allowed
    options.maxPhotons = photons;
    options.polars = polars;
    Progress progress;
    return precompute(v, options, progress, {});
}

// I_m for normal light and I_b / 2 pi of a voxel, of one table.
double multiple(const StfTable& t, std::size_t voxel) {
    return double(t.multiple[voxel * 3]);
}
double backlight(const StfTable& t, std::size_t voxel) {
    return double(t.backlight[voxel].x) / (2 * kPi);
}

// Compares with the rows of a profile computed by adding-doubling. A voxel knows the mean of its layer: at a row's
// depth it differs by h^2 / 24 f'' (h^2 / 6 f'' for the mean of two), which is estimated from the rows and allowed for.
void expectProfile(const nlohmann::json& profile, int layers, int tables, std::uint64_t photons) {
    const double tau = profile["tau"], albedo = profile["albedo"], g = profile["g"], h = tau / layers;
    SCOPED_TRACE("albedo " + std::to_string(albedo) + ", g " + std::to_string(g));
    const BaseVolume v = homogeneous({1, 1, layers}, {1, 1, h}, Rgb(1.0f), Rgb(float(albedo)), float(g));
    std::vector<StfTable> all;
    for (int k = 0; k < tables; ++k) {
        all.push_back(table(v, std::uint64_t(k), photons));
    }
    const auto& rows = profile["rows"];
    int compared = 0;
    for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
        const double depth = rows[i]["depth"], before = rows[i - 1]["depth"], after = rows[i + 1]["depth"];
        if (depth < 2 * h || depth > tau - 2 * h) {
            continue;
        }
        // The two voxels that meet here, or twice the same.
        const std::size_t above = std::size_t(std::lround(std::ceil(depth / h - 1 - 1e-6)));
        const std::size_t below = std::size_t(std::lround(std::floor(depth / h + 1e-6)));
        const auto check = [&](const char* key, double (*value)(const StfTable&, std::size_t)) {
            SCOPED_TRACE(std::string(key) + " at " + std::to_string(depth));
            const auto row = [&](std::size_t k) { return rows[k][key].get<double>(); };
            const double bend = 2 *
                                ((row(i + 1) - row(i)) / (after - depth) - (row(i) - row(i - 1)) / (depth - before)) /
                                (after - before);
            const Estimate e =
                estimate(all, [&](const StfTable& t) { return 0.5 * (value(t, above) + value(t, below)); });
            EXPECT_TRUE(agrees(e, row(i), 0.01, std::abs(bend) * h * h / 4));
        };
        check("I_m", multiple);
        check("I_b", backlight);
        ++compared;
    }
    EXPECT_GE(compared, 9);
}

TEST(Fluence, ThinIsotropicSlab) {
    expectProfile(reference("slab_cases.json")["internal_fluence"][0], 100, 32, 8000);
}

TEST(Fluence, ThickIsotropicSlab) {
    expectProfile(reference("slab_cases.json")["internal_fluence"][1], 100, 32, 4000);
}

TEST(Fluence, ForwardScatteringSlab) {
    expectProfile(reference("slab_cases.json")["internal_fluence"][2], 100, 32, 4000);
}

TEST(Fluence, FirstAndLastLayersLieWithinTheProfile) {
    const nlohmann::json data = reference("slab_cases.json");
    const auto& rows = data["internal_fluence"][1]["rows"]; // tau 5, first rows at 0 and 0.05
    const BaseVolume v = homogeneous({1, 1, 100}, {1, 1, 0.05}, Rgb(1.0f), Rgb(0.99f));
    std::vector<StfTable> all;
    for (std::uint64_t k = 0; k < 16; ++k) {
        all.push_back(table(v, 100 + k, 8000));
    }
    const Estimate top = estimate(all, [](const StfTable& t) { return multiple(t, 0); });
    EXPECT_LT(top.sigma, 0.01 * top.mean);
    EXPECT_GT(top.mean, rows[0]["I_m"].get<double>() - 4 * top.sigma);
    EXPECT_LT(top.mean, rows[1]["I_m"].get<double>() + 4 * top.sigma);
    const Estimate bottom = estimate(all, [](const StfTable& t) { return backlight(t, 99); });
    EXPECT_LT(bottom.sigma, 0.01 * bottom.mean);
    EXPECT_GT(bottom.mean, rows[13]["I_b"].get<double>() - 4 * bottom.sigma);
    EXPECT_LT(bottom.mean, rows[14]["I_b"].get<double>() + 4 * bottom.sigma);
}

TEST(Fluence, FurnaceOfTheTablesDirections) {
    // Conservative and index-matched: uniform radiance from above, summed over the table's directions, plus backlight
    // gives 4 pi at every depth. 18 polar nodes interpolate to 0.8 % (THEORY, sampling sizes).
    const int layers = 16;
    const double tau = 2, h = tau / layers;
    const BaseVolume v = homogeneous({1, 1, layers}, {1, 1, h}, Rgb(1.0f), Rgb(1.0f));
    std::vector<StfTable> all;
    for (std::uint64_t k = 0; k < 8; ++k) {
        all.push_back(table(v, 200 + k, 4000, 18));
    }
    const int steps = 2000;
    for (int z = 0; z < layers; ++z) {
        const Estimate e = estimate(all, [&](const StfTable& t) {
            double sum = double(t.backlight[std::size_t(z)].x);
            for (int i = 0; i < steps; ++i) {
                const double theta = 0.5 * kPi * (i + 0.5) / steps, s = std::sin(theta), c = std::cos(theta);
                const double dw = 2 * kPi * s * 0.5 * kPi / steps;
                const double im = double(t.multipleAt(std::size_t(z), t.directions.weights({float(s), 0, float(c)})).x);
                // Uncollided, averaged over the layer.
                const double a = z * h / c, b = h / c;
                sum += dw * (im + std::exp(-a) * -std::expm1(-b) / b);
            }
            return sum;
        });
        EXPECT_TRUE(agrees(e, 4 * kPi, 0.005, 0.008 * 4 * kPi)) << "layer " << z;
    }
}

TEST(Fluence, ReflectedBelowOfAThickSlab) {
    // Half infinite to 1e-7: the spherical albedo of the H function's table.
    for (double albedo : {0.5, 0.9}) {
        const double expected = reference("hfunc.json")["table"][albedo == 0.5 ? "0.5" : "0.9"]["R_sph"];
        const BaseVolume v = homogeneous({1, 1, 10}, {1, 1, 2}, Rgb(1.0f), Rgb(float(albedo)));
        std::vector<StfTable> all;
        for (std::uint64_t k = 0; k < 32; ++k) {
            all.push_back(table(v, 300 + k, 1000));
        }
        EXPECT_TRUE(agrees(estimate(all, [](const StfTable& t) { return double(t.reflectedBelow[0].x); }), expected));
    }
}

TEST(Fluence, TransmittedOfASlab) {
    // tau 5, albedo 0.99, g 0.5 of the reference cases; normal light, perpendicular irradiance 1.
    const BaseVolume v = homogeneous({1, 1, 5}, {1, 1, 1}, Rgb(1.0f), Rgb(0.99f), 0.5f);
    std::vector<StfTable> all;
    for (std::uint64_t k = 0; k < 32; ++k) {
        all.push_back(table(v, 400 + k, 4000));
    }
    EXPECT_TRUE(agrees(estimate(all, [](const StfTable& t) { return double(t.transmitted[0]); }), 0.3826006));
    EXPECT_NEAR(double(all[0].direct[0]), std::exp(-5), 1e-7);
    EXPECT_TRUE(agrees(estimate(all, [](const StfTable& t) { return double(t.reflectedBelow[0].x); }), 0.6092368));
}

} // namespace
