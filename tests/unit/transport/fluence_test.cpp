// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/support/chi_square.h"
#include "tests/unit/support/files.h"
#include "tests/unit/transport/walks.h"

using namespace stf;
using namespace stf::test;

namespace {

constexpr int kLayers = 100;

// Compares with the rows of a profile computed by adding-doubling: I_s and I_m of normal light, I_b / 2 pi of unit
// radiance from below. A voxel knows the mean of its layer: at a row's depth it differs by h^2 / 24 f'' (h^2 / 6 f''
// for the mean of two), which is estimated from the rows and allowed for.
void expectProfile(const nlohmann::json& profile, std::uint64_t photons, ChiSquare& chi) {
    const double tau = profile["tau"], albedo = profile["albedo"], g = profile["g"], h = tau / kLayers;
    SCOPED_TRACE("albedo " + std::to_string(albedo) + ", g " + std::to_string(g));
    const TileMedium medium =
        trueMedium(homogeneous({1, 1, kLayers}, {1, 1, h}, Rgb(1.0f), Rgb(float(albedo)), float(g)));
    const auto top = walkBatches(medium, normalLight(), 32, photons, fluenceRequest(0, 1 + std::uint64_t(chi.count())));
    const auto below = walkBatches(medium, diffuse(WalkSource::Kind::DiffuseBelow), 32, photons,
                                   fluenceRequest(0, 2 + std::uint64_t(chi.count())));
    const auto& rows = profile["rows"];
    int compared = 0;
    for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
        const double depth = rows[i]["depth"], before = rows[i - 1]["depth"], after = rows[i + 1]["depth"];
        if (depth < 2 * h || depth > tau - 2 * h) {
            continue;
        }
        // The two voxels that meet here, or twice the same.
        const std::size_t upper = std::size_t(std::lround(std::ceil(depth / h - 1 - 1e-6)));
        const std::size_t lower = std::size_t(std::lround(std::floor(depth / h + 1e-6)));
        const auto check = [&](const char* key, const std::vector<WalkTally>& batches, auto&& fluence) {
            SCOPED_TRACE(std::string(key) + " at " + std::to_string(depth));
            const auto row = [&](std::size_t k) { return rows[k][key].get<double>(); };
            const double bend = 2 *
                                ((row(i + 1) - row(i)) / (after - depth) - (row(i) - row(i - 1)) / (depth - before)) /
                                (after - before);
            std::vector<double> values;
            for (const WalkTally& b : batches) {
                values.push_back(0.5 * (fluence(b, upper) + fluence(b, lower)) / (double(b.photons) * h));
            }
            EXPECT_TRUE(agrees(estimate(values), row(i), 0.04, std::abs(bend) * h * h / 4));
            return values;
        };
        check("I_s", top, [](const WalkTally& t, std::size_t z) { return t.uncollided[z * 3]; });
        const auto m = check("I_m", top, [](const WalkTally& t, std::size_t z) { return t.collided[z * 3]; });
        // The flux pi of unit radiance, over 2 pi.
        check("I_b", below,
              [](const WalkTally& t, std::size_t z) { return 0.5 * (t.collided[z * 3] + t.uncollided[z * 3]); });
        chi.add({m}, {rows[i]["I_m"].get<double>()});
        ++compared;
    }
    EXPECT_GE(compared, 9);
}

TEST(Fluence, ProfilesOfSlabs) {
    ChiSquare chi;
    const nlohmann::json data = reference("slab_cases.json");
    expectProfile(data["internal_fluence"][0], 16000, chi);
    expectProfile(data["internal_fluence"][1], 3000, chi);
    expectProfile(data["internal_fluence"][2], 3000, chi);
}

TEST(Fluence, FirstAndLastLayersLieWithinTheProfile) {
    const nlohmann::json data = reference("slab_cases.json");
    const auto& rows = data["internal_fluence"][1]["rows"]; // tau 5, first rows at 0 and 0.05
    const TileMedium medium = trueMedium(homogeneous({1, 1, 100}, {1, 1, 0.05}, Rgb(1.0f), Rgb(0.99f)));
    const auto expectBetween = [&](const char* key, WalkSource::Kind kind, std::size_t a, std::size_t b,
                                   auto&& fluence) {
        const Estimate e = estimate(walkBatches(medium, diffuse(kind), 32, 4000),
                                    [&](const WalkTally& t) { return fluence(t) / (double(t.photons) * 0.05); });
        EXPECT_LT(e.sigma, 0.015 * e.mean);
        EXPECT_GT(e.mean, rows[a][key].get<double>() - 4 * e.sigma);
        EXPECT_LT(e.mean, rows[b][key].get<double>() + 4 * e.sigma);
    };
    expectBetween("I_m", WalkSource::Kind::Direction, 0, 1, [](const WalkTally& t) { return t.collided[0]; });
    expectBetween("I_b", WalkSource::Kind::DiffuseBelow, 13, 14,
                  [](const WalkTally& t) { return 0.5 * (t.collided[99 * 3] + t.uncollided[99 * 3]); });
}

// Net flux down a slab falls by what is absorbed: F(z) = -(T + A below z), and by nothing where nothing is.
TEST(Fluence, NetFluxIsWhatIsAbsorbedBelowOrLeaves) {
    for (double n : {1.0, 1.5}) {
        BaseVolume v = homogeneous({1, 1, 10}, {1, 1, 0.3}, Rgb(1.0f), Rgb(0.9f), 0.4f);
        v.ior.assign(v.voxelCount(), float(n));
        const TileMedium medium = trueMedium(v, true);
        WalkRequest request = fluenceRequest();
        request.flux = true;
        const auto batches = walkBatches(medium, obliqueLight(0.6), 64, 3000, request);
        for (std::size_t z : {std::size_t(0), std::size_t(4), std::size_t(9)}) {
            std::vector<double> values;
            for (const WalkTally& b : batches) {
                double down = transmittance(b), track = 0;
                for (std::size_t k = z; k < 10; ++k) {
                    // kappa (1 - a) times the fluence: half of the layer's own.
                    track += (k == z ? 0.5 : 1) * (b.collided[k * 12] + b.uncollided[k * 12]);
                }
                down += 0.1 * track / double(b.photons);
                const double flux = (b.collided[z * 12 + 3] + b.uncollided[z * 12 + 3]) / (0.3 * double(b.photons));
                values.push_back(down + flux);
            }
            const Estimate e = estimate(values);
            EXPECT_LT(e.sigma, 0.004);
            EXPECT_LE(std::abs(e.mean), 4 * e.sigma + 1e-3) << "layer " << z << ", n " << n; // bend within the layer
        }
    }
}

} // namespace
