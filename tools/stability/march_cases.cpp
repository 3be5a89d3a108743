// SPDX-License-Identifier: Apache-2.0
// Point 1: a step of any optical depth.
#include "stfLib/optics/step_weights.h"
#include "stfLib/render/tile_march.h"
#include "tools/stability/small_scene.h"

#include <cmath>

namespace stf {

namespace {

StabilityOutcome weightsOfAStep(StabilityRun&) {
    long double worstT = 0, worstPhi = 0;
    bool inRange = true;
    for (int e = -120; e <= 60; ++e) {
        const float x = float(std::pow(10.0, e / 10.0));
        const StepWeights w = stepWeights(x);
        const long double t = std::exp(-static_cast<long double>(x)),
                          phi = -std::expm1(-static_cast<long double>(x)) / x;
        inRange = inRange && w.transmittance >= 0 && w.transmittance <= 1 && w.phi1 >= 0 && w.phi1 <= 1;
        if (t > 1e-37L) { // below, a float has no digits to compare
            worstT = std::max(worstT, std::abs(w.transmittance / t - 1));
        }
        worstPhi = std::max(worstPhi, std::abs(w.phi1 / phi - 1));
    }
    return {measuredText("relative errors: T %.1e, weight %.1e; all in range: %s", double(worstT), double(worstPhi),
                         inRange ? "yes" : "no"),
            inRange && worstT < 1e-6L && worstPhi < 1e-6L};
}

// Radiance of a glowing, absorbing layer of optical depth tau, cut into steps, and what is left of light from below.
struct Marched {
    double radiance, transmittance;
};
Marched marchGlow(double tau, int steps) {
    BaseVolume v = uniformVolume(tau, 0, 0, steps, 1);
    v.emission.assign(v.voxelCount(), Rgb(1.0f));
    const TileMedium medium(v, TransportForm::DE1);
    StfTable table;
    table.size = v.size;
    table.voxelMm = v.voxelMm;
    TileMarch march(medium, table);
    PixelSampler sampler(0, 0, 0);
    march.begin(sampler);
    march.setFrame(nullptr, 0, {0, 0, 1});
    march.segment({0.5f, 0.5f, 0}, {0, 0, float(1 / v.voxelMm.z)}, 1);
    const double t = double(march.transmittance().y);
    const TileRadiance r = march.finish();
    return {double(r.single.y + r.multiple.y), t};
}

StabilityOutcome constantSource(StabilityRun&) {
    double worst = 0;
    for (int e = -12; e <= 6; ++e) {
        const double tau = double(float(std::pow(10.0, e)));
        worst = std::max(worst, std::abs(marchGlow(tau, 1).radiance * tau / -std::expm1(-tau) - 1));
    }
    return {measuredText("largest relative error %.1e", worst), worst < 1e-6};
}

StabilityOutcome halvedSteps(StabilityRun&) {
    double worst = 0, worstT = 0; // of differences
    // Not beyond 4: with less than 1 % of their light left paths may end by roulette.
    for (const double tau : {1e-6, 1e-3, 0.1, 1.0, 4.0}) {
        const Marched one = marchGlow(tau, 1);
        for (int steps = 2; steps <= 64; steps *= 2) {
            const Marched many = marchGlow(tau, steps);
            worst = std::max(worst, std::abs(many.radiance / one.radiance - 1));
            worstT = std::max(worstT, std::abs(many.transmittance / one.transmittance - 1));
        }
    }
    // 64 factors, each rounded to 6e-8.
    return {measuredText("radiance changes by %.1e, transmittance by %.1e", worst, worstT),
            worst < 4e-6 && worstT < 4e-6};
}

} // namespace

void addMarchCases(std::vector<StabilityCase>& all) {
    all.push_back({"1.step-weights", "one step of optical depth 1e-12 to 1e6",
                   "transmittance and weight of a source in 0..1, relative error below 1e-6", false, false,
                   weightsOfAStep});
    all.push_back({"1.constant-source", "a glowing voxel of optical depth 1e-12 to 1e6, marched",
                   "radiance S (1 - exp(-tau)) / kappa, relative error below 1e-6", false, false, constantSource});
    all.push_back({"1.halved-steps", "a glowing layer of optical depth 1e-6 to 4 cut into 1 to 64 steps",
                   "the same radiance and transmittance up to rounding, 4e-6", false, false, halvedSteps});
}

} // namespace stf
