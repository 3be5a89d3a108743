// SPDX-License-Identifier: Apache-2.0
// Points 2, 7 and 9: energy, reciprocity and limits of slabs, by the walks of tables and by tables themselves.
#include "stfLib/core/dipole.h"
#include "stfLib/optics/h_function.h"
#include "tools/stability/stability_case.h"
#include "tools/stf/slab_stf.h"
#include "tools/stf/slab_walk.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

SlabOptions slab(double tau, double albedo, double g, double ior = 1) {
    SlabOptions o;
    o.layers = {{tau, albedo, g}};
    o.ior = ior;
    o.photons = 20'000;
    return o;
}

SlabOptions byTable(double tau, double albedo, double g, double ior = 1) {
    SlabOptions o = slab(tau, albedo, g, ior);
    o.method = SlabOptions::Method::Stf;
    o.quality = 0.005;
    return o;
}

StabilityOutcome conservative(StabilityRun& run) {
    double most = 0, balance = 0, split = 0;
    bool ok = true;
    for (const double n : {1.0, 1.5}) {
        for (const double tau : {1e-6, 1.0, 30.0}) {
            const SlabResult r = slabByWalks(slab(tau, 1, 0.5, n), run.progress);
            most = std::max(most, r.a);
            const double off = std::abs(r.r + r.t - 1);
            // Internal reflection splits walks, and roulette ends some of the parts: right in the mean.
            (n == 1 ? balance : split) = std::max(n == 1 ? balance : split, off);
            ok = ok && off <= std::max(1e-5, n == 1 ? 0 : 3 * (r.rError + r.tError));
        }
    }
    return {measuredText("A at most %.1e; R + T - 1 at most %.1e, with an index %.1e", most, balance, split),
            most <= 1e-6 && ok};
}

StabilityOutcome nearlyConservative(StabilityRun& run) {
    double worst = 0;
    std::uint64_t lost = 0;
    for (const double n : {1.0, 1.5}) {
        for (const double tau : {1.0, 300.0}) {
            SlabOptions o = slab(tau, 1 - 1e-7, 0, n);
            o.photons = 4000;
            const SlabResult r = slabByWalks(o, run.progress);
            lost += r.lost;
            worst =
                std::max(worst, std::abs(r.r + r.t + r.a - 1) / std::max(1e-5, 3 * (r.rError + r.tError + r.aError)));
        }
    }
    return {measuredText("R + T + A - 1: %.2f of what is allowed; walks lost: %d", worst, int(lost)),
            worst <= 1 && lost == 0};
}

StabilityOutcome blackSlab(StabilityRun& run) {
    double worst = 0, reflected = 0;
    for (const double tau : {1e-3, 1.0, 5.0}) {
        const SlabResult r = slabByTable(byTable(tau, 0, 0), run.progress);
        worst = std::max(worst, std::abs(r.t / std::exp(-tau) - 1));
        reflected = std::max(reflected, r.r);
    }
    return {measuredText("T off by %.1e, R at most %.1e", worst, reflected), worst < 1e-5 && reflected == 0};
}

StabilityOutcome monotone(StabilityRun& run) {
    double last = -1, steepest = 1;
    std::string text = "R by albedo:";
    for (const double albedo : {0.0, 0.3, 0.6, 0.9, 0.99, 1.0}) {
        const double r = slabByTable(byTable(4, albedo, 0), run.progress).r;
        steepest = std::min(steepest, r - last);
        text += measuredText(" %.4f", r);
        last = r;
    }
    last = -1;
    text += "; by tau:";
    for (const double tau : {1e-6, 0.1, 1.0, 4.0, 16.0, 64.0}) {
        const double r = slabByTable(byTable(tau, 0.99, 0), run.progress).r;
        steepest = std::min(steepest, r - last);
        text += measuredText(" %.4f", r);
        last = r;
    }
    return {text, steepest > 0};
}

StabilityOutcome isReciprocal(StabilityRun& run, double g, double allowed) {
    double worst = 0, ratio = 1;
    const double cosines[][2] = {{0.9, 0.3}, {0.6, 0.25}};
    for (const auto& pair : cosines) {
        SlabResult::View v[2];
        for (int k = 0; k < 2; ++k) {
            SlabOptions o = byTable(4, 0.9, g);
            o.mu = pair[k];
            o.view = {pair[1 - k]};
            v[k] = slabByTable(o, run.progress).view.at(0);
        }
        // pi L / (E mu0) is symmetric.
        const double r = v[0].factor / v[1].factor - 1;
        const double noise = 3 * (v[0].error + v[1].error) / v[0].factor;
        if (std::abs(r) - noise > worst || worst == 0) {
            worst = std::max(0.0, std::abs(r) - noise);
            ratio = std::abs(r);
        }
    }
    return {measuredText("swapped, the reflectance factor changes by %.2f %% (beyond noise %.2f %%)", 100 * ratio,
                         100 * worst),
            worst < allowed};
}

// Reflectance for normal light against adding-doubling.
StabilityOutcome reflectance(StabilityRun& run, const SlabOptions& o, double exact, double low, double high) {
    const SlabResult r = slabByTable(o, run.progress);
    const double off = r.r / exact - 1, noise = 3 * r.rError / exact;
    return {measuredText("R %.6f, exact %.6f: %+.2f %% +- %.2f %%", r.r, exact, 100 * off, 100 * r.rError / exact),
            off > low - noise && off < high + noise && noise < 0.035};
}

StabilityOutcome isotropicSlabs(StabilityRun& run) {
    const struct {
        double tau, albedo, n, exact;
    } cases[] = {{0.01, 0.9, 1, 0.004465}, {1, 1, 1, 0.341329}, {1, 0.9, 1.33, 0.225472}, {1, 1, 1.5, 0.358948}};
    double worst = 0;
    bool ok = true;
    for (const auto& c : cases) {
        SlabOptions o = byTable(c.tau, c.albedo, 0, c.n);
        o.quality = 0.002;
        const SlabResult r = slabByTable(o, run.progress);
        worst = std::max(worst, std::abs(r.r / c.exact - 1));
        ok = ok && std::abs(r.r / c.exact - 1) < 0.005 + 3 * r.rError / c.exact;
    }
    return {measuredText("R off by at most %.2f %%", 100 * worst), ok};
}

StabilityOutcome thickIsSemiInfinite(StabilityRun& run) {
    double worst = 0;
    for (const double albedo : {0.5, 0.9, 0.99}) {
        const SlabResult r = slabByTable(byTable(albedo > 0.95 ? 100 : 30, albedo, 0), run.progress);
        worst = std::max(worst, std::abs(r.r / HFunction(1 - albedo).reflectance(1) - 1));
    }
    return {measuredText("R off by at most %.2f %% of Chandrasekhar's", 100 * worst), worst < 0.01};
}

StabilityOutcome absorber(StabilityRun& run) {
    SlabOptions diffuse = byTable(5, 0, 0);
    diffuse.incidence = SlabOptions::Incidence::Diffuse;
    const double t = slabByTable(byTable(5, 0, 0), run.progress).t, d = slabByTable(diffuse, run.progress).t;
    return {measuredText("T %.6f (exact .006738), diffuse %.6f (2 E_3(5) = .001756)", t, d),
            std::abs(t - std::exp(-5.0)) < 1e-7 && std::abs(d - 0.001756) < 0.005 * 0.001756};
}

StabilityOutcome dipoleLimits(StabilityRun&) {
    bool ok = true;
    double total = 0;
    for (const double sigmaA : {0.0, 1e-6, 0.01, 10.0}) {
        const Dipole d(sigmaA, 1);
        const double length = sigmaA > 0 ? d.diffusionLength() : 100;
        double last = INFINITY;
        for (int e = -120; e <= 40; ++e) {
            const double r = length * std::pow(10.0, e / 10.0), k = double(d.kernel(float(r * r)));
            ok = ok && std::isfinite(k) && k >= 0 && k <= last * (1 + 1e-5);
            last = k;
        }
        total = sigmaA > 0 ? std::max(total, std::abs(d.discIntegral(1e4 * length) / d.planeIntegral() - 1)) : total;
    }
    const Dipole none(1, 0), white(0, 1);
    ok = ok && none.kernel(1) == 0 && none.diffuseAlbedo() == 0 && std::abs(white.diffuseAlbedo() - 1) < 1e-5;
    return {measuredText("finite and falling: %s; disc of 1e4 lengths is the plane to %.1e; albedo without absorption "
                         "1 - %.1e, without scattering %.0e",
                         ok ? "yes" : "no", total, 1 - white.diffuseAlbedo(), none.diffuseAlbedo()),
            ok && total < 1e-6};
}

} // namespace

void addSlabCases(std::vector<StabilityCase>& all) {
    all.push_back({"2.albedo-1", "walks, albedo 1, tau 1e-6, 1, 30, index 1 and 1.5",
                   "A <= 1e-6; R + T = 1 within 1e-5, with an index (where walks split) within 3 standard errors",
                   false, false, conservative});
    all.push_back({"2.albedo-1-1e-7", "walks, albedo 1 - 1e-7, tau 1 and 300, index 1 and 1.5",
                   "they end; R + T + A = 1 within 3 standard errors", true, false, nearlyConservative});
    all.push_back({"2.albedo-0", "tables, albedo 0, tau .001, 1, 5", "T = exp(-tau) within 1e-5, R = 0", false, false,
                   blackSlab});
    all.push_back({"2.monotone", "tables, albedo 0 to 1 at tau 4; tau 1e-6 to 64 at albedo .99",
                   "R grows with albedo and, at index 1, with tau", true, false, monotone});

    all.push_back({"7.reciprocity", "light and view of a slab swapped, tau 4, albedo .9, g 0",
                   "the reflectance factor changes by less than 1 % beyond 3 standard errors", false, false,
                   [](StabilityRun& run) { return isReciprocal(run, 0, 0.01); }});
    all.push_back({"7.reciprocity-g.8", "the same, g .8",
                   "known limit: two moments hold the multiple part, 10 % of asymmetry remain", true, true,
                   [](StabilityRun& run) { return isReciprocal(run, 0.8, 0.10); }});

    all.push_back({"9.isotropic-slabs", "g 0: tau .01 and 1, albedo .9 and 1, index 1, 1.33, 1.5",
                   "R of adding-doubling within .5 %", true, false, isotropicSlabs});
    all.push_back({"9.semi-infinite", "tau 30 (100 for albedo .99), albedo .5, .9, .99",
                   "R of a half space (H function) within 1 %", true, false, thickIsSemiInfinite});
    all.push_back({"9.absorber", "pure absorber of tau 5, normal and diffuse light",
                   "exp(-5) within 1e-7, 2 E_3(5) within .5 %", false, false, absorber});
    all.push_back({"9.dipole", "r from 1e-12 to 1e4 diffusion lengths, sigma_a 0 to 10, sigma_s 0",
                   "finite, falling, whole; returns all without absorption, none without scattering", false, false,
                   dipoleLimits});
    all.push_back({"9.forward-thin", "dE1, tau 1, albedo .999999, g .9",
                   "known limit: the backward tail of a narrow peak, R at most 9 % too bright", false, true,
                   [](StabilityRun& run) { return reflectance(run, byTable(1, 0.999999, 0.9), 0.026091, 0, 0.09); }});
    all.push_back({"9.backward", "dE1, tau 2, albedo .9, g -.9",
                   "known limit: there is no peak to scale away, R at most 10.6 % too dark", false, true,
                   [](StabilityRun& run) { return reflectance(run, byTable(2, 0.9, -0.9), 0.530159, -0.106, 0); }});
    all.push_back(
        {"9.forward-thick", "dE1, tau 10, albedo .99, g .9, index 1.33", "R within 3 %", true, false,
         [](StabilityRun& run) { return reflectance(run, byTable(10, 0.99, 0.9, 1.33), 0.255008, -0.03, 0.03); }});
}

} // namespace stf
