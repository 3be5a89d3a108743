// SPDX-License-Identifier: Apache-2.0
// Points 4 and 5: phase function and Fresnel's equations.
#include "stfLib/base/random.h"
#include "stfLib/optics/delta_eddington.h"
#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/gauss_legendre.h"
#include "stfLib/optics/phase.h"
#include "tools/stability/small_scene.h"

#include <cmath>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;

StabilityOutcome phaseIntegral(StabilityRun&) {
    const GaussLegendre rule(64);
    double worst = 0, worstG = 0;
    for (const float g : {0.0f, 1e-8f, -1e-8f, 0.5f, 0.9f, -0.9f, 0.999f, -0.999f}) {
        // In t with 1 -+ cos = 2 (e^(t) - 1) (1 - |g|)^2 / ...: a logarithm of the angle resolves any peak.
        const double m = 1 - std::abs(double(g)), low = std::log(m * m + 1e-6), high = std::log(2 + m * m + 1e-6);
        double sum = 0, moment = 0;
        constexpr int kPanels = 16;
        for (int p = 0; p < kPanels; ++p) {
            for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
                const double t = low + (high - low) * (p + rule.nodes[i]) / kPanels;
                const double away = std::exp(t) - (m * m + 1e-6); // 1 - cos for g > 0, 1 + cos for g < 0
                const double weight = rule.weights[i] * (high - low) / kPanels * std::exp(t) * 2 * kPi;
                const double c = g < 0 ? away - 1 : 1 - away, s = std::sqrt(std::max(0.0, away * (2 - away)));
                const double value = double(henyeyGreenstein(g, {0, 0, 1}, normalize(Vec3f(float(s), 0, float(c)))));
                sum += value * weight;
                moment += value * c * weight;
            }
        }
        worst = std::max(worst, std::abs(sum - 1));
        worstG = std::max(worstG, std::abs(moment - double(g)));
    }
    return {measuredText("integral off by %.1e, mean cosine by %.1e", worst, worstG), worst < 1e-4 && worstG < 1e-4};
}

StabilityOutcome sampledCosine(StabilityRun&) {
    constexpr int kSamples = 200'000;
    double worst = 0;
    for (const float g : {0.0f, 1e-8f, 0.9f, -0.9f, 0.999f, -0.999f}) {
        CounterRng rng(4, 1);
        double sum = 0;
        for (int i = 0; i < kSamples; ++i) {
            const float u = rng.uniform();
            sum += double(sampleHenyeyGreenstein(g, {0, 0, 1}, u, rng.uniform()).z);
        }
        const double sigma = std::sqrt((1 - double(g) * double(g)) / 3 / kSamples); // <cos^2> = (1 + 2 g^2) / 3
        worst = std::max(worst, std::abs(sum / kSamples - double(g)) / sigma);
    }
    return {measuredText("largest deviation %.1f standard errors", worst), worst < 4};
}

StabilityOutcome continuousAtZero(StabilityRun&) {
    double phase = 0, form = 0;
    for (const float g : {1e-8f, -1e-8f, 1e-5f, -1e-5f}) {
        for (const float c : {-1.0f, -0.3f, 0.0f, 0.7f, 1.0f}) {
            const Vec3f to = normalize(Vec3f(std::sqrt(1 - c * c), 0, c));
            const double value = double(henyeyGreenstein(g, {0, 0, 1}, to)) * 4 * kPi;
            phase = std::max(phase, std::abs(value - 1) - 4 * std::abs(double(g))); // slope 3 cos
        }
        const DeltaScale s = deltaScale(TransportForm::DE1, g);
        form = std::max(form, double(std::abs(s.g - g) + std::abs(s.keep - 1)));
    }
    return {measuredText("phase function beyond its slope by %.1e, scaled medium by %.1e", phase, form),
            phase < 1e-6 && form < 1e-6};
}

StabilityOutcome refusedCosines(StabilityRun&) {
    int refused = 0;
    std::string text;
    for (const float g : {1.0f, -1.0f, 1.5f}) {
        BaseVolume v = uniformVolume(1, 0.9, 0, 2, 1);
        v.g.assign(v.voxelCount(), g);
        try {
            validate(v);
        } catch (const Error& e) {
            ++refused;
            text = e.what();
        }
    }
    return {measuredText("%d of 3 refused: %s", refused, text.c_str()),
            refused == 3 && text.find("'g'") != std::string::npos};
}

const float kIndices[] = {1.0f, 1.0001f, 1 / 1.0001f, 1 / 1.5f, 1.33f, 1.5f, 2.5f, 0.4f};

StabilityOutcome fresnelRange(StabilityRun&) {
    bool inRange = true;
    double one = 0;
    for (const float n : kIndices) {
        for (int i = 0; i <= 2000; ++i) {
            const float c = i == 0 ? 1e-7f : float(i) / 2000;
            const FresnelSplit s = fresnel(c, n);
            inRange = inRange && s.reflectance >= 0 && s.reflectance <= 1 && s.cosT >= 0 && s.cosT <= 1;
            one = n == 1 ? std::max(one, double(s.reflectance)) : one;
        }
        // The edge of total reflection, to both sides of it.
        if (n < 1) {
            const float edge = std::sqrt((1 - n) * (1 + n));
            for (const float c : {std::nextafter(edge, 0.0f), edge, std::nextafter(edge, 1.0f)}) {
                inRange = inRange && fresnelReflectance(c, n) <= 1 && fresnelReflectance(c, n) > 0.9f;
            }
        }
    }
    return {measuredText("all in range: %s; largest reflectance at index 1: %.1e", inRange ? "yes" : "no", one),
            inRange && one == 0};
}

StabilityOutcome fresnelReciprocity(StabilityRun&) {
    double worst = 0, furnace = 0;
    for (const float n : kIndices) {
        for (int i = 1; i <= 500; ++i) {
            // The way back in double precision: a cosine near grazing, rounded, is that of another direction.
            const float c = float(i) / 500;
            const FresnelSplit s = fresnel(c, n);
            if (s.reflectance < 1) {
                const double eta = double(n), cosT = fresnelSplit<double>(double(c), eta).cosT;
                const double back = fresnelSplit<double>(cosT, 1 / eta).reflectance;
                worst = std::max(worst, std::abs(back - double(s.reflectance)));
            }
        }
        if (n > 1) {
            const double eta = double(n);
            furnace =
                std::max(furnace, std::abs(diffuseFresnel(1 / eta) - (1 - (1 - diffuseFresnel(eta)) / (eta * eta))));
        }
    }
    return {measuredText("reciprocity to %.1e, balance of diffuse light to %.1e", worst, furnace),
            worst < 2e-6 && furnace < 1e-10};
}

StabilityOutcome indexNearOne(StabilityRun& run) {
    SmallScene scene(run);
    scene.settings.quality = 0.01f;
    scene.setCore(0.9);
    scene.setLightCosine(0.6);
    const SmallPicture one = scene.render();
    scene.volume.ior.assign(scene.volume.voxelCount(), 1.0001f);
    const SmallPicture near = scene.render();
    const double change = near.mean().y / one.mean().y - 1;
    return {measuredText("mean radiance %.6f and %.6f: %+.2f %%, tables good to %.2f %%", one.mean().y, near.mean().y,
                         100 * change, 100 * near.tableError),
            near.finite() && near.entry("fresnel").runs && !one.entry("fresnel").runs && std::abs(change) < 0.02};
}

} // namespace

void addOpticsCases(std::vector<StabilityCase>& all) {
    all.push_back({"4.phase-integral", "g = 0, +-1e-8, .5, +-.9, +-.999",
                   "the phase function integrates to 1 with mean cosine g, within 1e-4", false, false, phaseIntegral});
    all.push_back({"4.sampled-cosine", "200 000 sampled directions for g = 0, 1e-8, +-.9, +-.999",
                   "their mean cosine is g within 4 standard errors", false, false, sampledCosine});
    all.push_back({"4.continuous-at-zero", "g = +-1e-8, +-1e-5",
                   "phase function and scaled medium are those of g = 0 up to the slope", false, false,
                   continuousAtZero});
    all.push_back({"4.refused", "g = 1, -1, 1.5 in a volume", "each is refused with a message that names the grid",
                   false, false, refusedCosines});
    all.push_back({"5.fresnel-range", "index .4 to 2.5, cosine 1e-7 to 1, both sides of total reflection",
                   "reflectance in 0..1, exactly 0 at index 1", false, false, fresnelRange});
    all.push_back({"5.fresnel-reciprocity", "the same indices from both sides",
                   "R(c, n) = R(c', 1/n) within 2e-6; F_int = 1 - (1 - F_ext) / n^2 "
                   "within 1e-10",
                   false, false, fresnelReciprocity});
    all.push_back({"5.index-1.0001", "a shell of index 1.0001 over a core, oblique light, rendered",
                   "finite, within 2 % of index 1 (twice the tables' error)", false, false, indexNearOne});
}

} // namespace stf
