// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_balance.h"

#include "stfLib/base/hemisphere.h"
#include "stfLib/base/parallel.h"
#include "stfLib/render/integrator.h"
#include "stfLib/render/round_series.h"
#include "stfLib/render/shell_glow.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace stf {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kSamples = 24'000;           ///< of all shells together, as far as
constexpr std::size_t kLeast = 300, kMost = 6'000; ///< of one
constexpr std::size_t kRays = 1'000'000;           ///< of all samples
constexpr int kLeastRays = 16, kMostRays = 128;    ///< of one
constexpr int kViews = 4;                          ///< directions in which what leaves a sample is looked at
constexpr int kMostRounds = 40;
constexpr double kSettled = 0.005;   ///< of all light that leaves shells, what further rounds would change
constexpr double kRareShells = 2e-4; ///< of all rays: below, shells do not light each other
constexpr std::uint64_t kGatherSeed = 0x676174686572, kViewSeed = 0x76696577;

double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string samplingKey(const ShellObject& o, std::size_t wanted, std::uint64_t seed) {
    return hashOf(o.surface->points) + hashOf(o.surface->triangles) + std::to_string(wanted) + ";" +
           std::to_string(seed) + ";" + std::to_string(o.mmPerUnit);
}

// Radiance that leaves a shell as it is lit now, mean by the cosine, at the samples of its surface.
std::vector<Rgb> exitance(const PreparedInstance& instance, const PreparedScene& scene, const SurfaceSampling& at,
                          std::uint64_t seed, Progress& progress) {
    std::vector<Rgb> leaving(at.samples.count());
    parallelFor(leaving.size(), 64, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        Integrator integrator(scene);
        for (std::size_t i = begin; i < end; ++i) {
            const RayHit hit = hitAt(instance, at.samples.places[i]);
            Ray ray;
            const Surfel surfel = surfelAt(instance, ray, hit);
            ray.origin = instance.worldPoint(surfel.objectPoint);
            Vec3f x, y;
            orthonormalBasis(surfel.normal, x, y);
            Rgb sum(0.0f);
            for (int k = 0; k < kViews; ++k) {
                PixelSampler sampler(seed, i, std::uint32_t(k));
                const Vec3f d = cosineHemisphere(sampler.next2d());
                ray.direction = -normalize(x * d.x + y * d.y + surfel.normal * d.z);
                if (dot(Vec3f(instance.worldToObject.vector(Vec3d(ray.direction))), hit.geometricNormal) < 0) {
                    sum += integrator.scattered(instance, ray, hit, at.spacingMm, sampler);
                }
            }
            leaving[i] = sum / float(kViews);
        }
    });
    return leaving;
}

struct Change {
    double difference = 0, all = 0;
    void add(const std::vector<Rgb>& before, const std::vector<Rgb>& now) {
        for (std::size_t i = 0; i < now.size(); ++i) {
            all += double(average(now[i]));
            difference += std::abs(double(average(now[i])) - (before.empty() ? 0.0 : double(average(before[i]))));
        }
    }
    double relative() const { return all > 0 ? difference / all : 0.0; }
};

} // namespace

LightBalance::Report LightBalance::solve(PreparedScene& scene, bool bounces, std::uint64_t seed, Progress& progress) {
    Report report;
    std::vector<PreparedInstance*> shells;
    for (PreparedInstance& i : scene.instances) {
        i.core.clear();
        i.indirect = {};
        i.exitant.clear();
        if (i.mesh->shell) {
            shells.push_back(&i);
        }
    }
    scene.shellsSeeOthers = false;
    scene.glow = nullptr;
    scene.keepsDomes = bounces && scene.irradianceCache;
    const bool emission = std::any_of(shells.begin(), shells.end(),
                                      [](const PreparedInstance* i) { return i->mesh->shell->medium->emits(); });
    const bool lit = scene.lights.count() > 0 || emission;
    const bool shines = std::any_of(scene.instances.begin(), scene.instances.end(),
                                    [](const PreparedInstance& i) { return i.material && i.material->emits(); });
    if (shells.empty() || !(lit || shines)) {
        cores_.dropUnused();
        samplings_.dropUnused();
        return report;
    }

    // Who sees whom, and what plain surfaces send.
    auto start = Clock::now();
    std::vector<std::unique_ptr<LightGather>> gathers(shells.size());
    std::vector<char> seen(scene.instances.size(), 0);
    std::vector<std::shared_ptr<const SurfaceSampling>> kept;
    if (bounces) {
        const std::size_t wanted = std::clamp(kSamples / shells.size(), kLeast, kMost);
        const int rays =
            int(std::clamp(kRays / (wanted * shells.size()), std::size_t(kLeastRays), std::size_t(kMostRays)));
        std::size_t links = 0;
        for (std::size_t s = 0; s < shells.size(); ++s) {
            const ShellObject& shell = *shells[s]->mesh->shell;
            const std::string key = samplingKey(shell, wanted, seed);
            std::shared_ptr<const SurfaceSampling> sampling = samplings_.find(key);
            if (!sampling) {
                sampling = samplings_.keep(key, SurfaceSampling(shell, wanted, seed));
            }
            kept.push_back(sampling);
            gathers[s] = std::make_unique<LightGather>(*shells[s], scene, sampling, rays,
                                                       seed + kGatherSeed + shells[s]->index, progress);
            report.samples += sampling->samples.count();
            links += gathers[s]->markSeen(seen);
        }
        report.gathers = shells.size();
        report.raysPerSample = rays;
        report.shellShare = double(links) / std::max(1.0, double(report.samples) * double(rays));
        if (report.shellShare < kRareShells) {
            std::fill(seen.begin(), seen.end(), 0);
        }
    }
    const auto gather = [&](std::size_t s) {
        if (gathers[s] && !gathers[s]->dark()) {
            shells[s]->indirect = gathers[s]->light(scene);
            scene.shellsSeeOthers = true;
        }
    };
    for (std::size_t s = 0; s < shells.size(); ++s) {
        gather(s);
    }
    report.indirectSeconds += since(start);

    // The cores, and by turns what leaves the shells that are seen.
    start = Clock::now();
    std::vector<std::unique_ptr<CoreLighting>> cores(shells.size());
    const auto solveCore = [&](std::size_t s) {
        if (cores[s]) {
            shells[s]->core = shells[s]->mesh->shell->grid->spreadCoreRadiance(cores[s]->radiance(progress));
        }
    };
    for (std::size_t s = 0; s < shells.size(); ++s) {
        const ShellObject& shell = *shells[s]->mesh->shell;
        if (!shell.coreBlack && (scene.lights.count() > 0 || shell.medium->emits() || gathers[s])) {
            const std::shared_ptr<const ShellCore> core = cores_.prepare(shell, seed, progress);
            cores[s] = std::make_unique<CoreLighting>(core, *shells[s], scene, seed, progress);
            solveCore(s);
            report.core = report.cores++ == 0 ? core->summary : report.core;
        }
    }
    report.coreSeconds = since(start);
    start = Clock::now();
    const bool exchange = std::any_of(seen.begin(), seen.end(), [](char c) { return c != 0; });
    RoundSeries series(kSettled);
    while (exchange && series.rounds() < kMostRounds && (series.rounds() == 0 || !series.settled())) {
        Change change;
        std::vector<std::vector<Rgb>> leaving(shells.size());
        for (std::size_t s = 0; s < shells.size(); ++s) {
            if (seen[shells[s]->index]) {
                const SurfaceSampling& at = gathers[s]->sampling();
                leaving[s] = at.toSurface.apply(exitance(*shells[s], scene, at, seed + kViewSeed, progress));
                change.add(shells[s]->exitant, leaving[s]);
            }
        }
        series.add(change.relative());
        const float leap = float(series.leap());
        for (std::size_t s = 0; s < shells.size(); ++s) {
            for (std::size_t i = 0; leap > 0 && i < leaving[s].size(); ++i) {
                const Rgb moved = leaving[s][i] + (leaving[s][i] - shells[s]->exitant[i]) * leap;
                leaving[s][i] = {std::max(0.0f, moved.x), std::max(0.0f, moved.y), std::max(0.0f, moved.z)};
            }
            shells[s]->exitant = std::move(leaving[s]);
        }
        for (std::size_t s = 0; s < shells.size(); ++s) {
            gather(s);
            solveCore(s);
        }
    }
    report.rounds = series.rounds();
    report.lastChange = series.lastChange();
    if (scene.irradianceCache && scene.surfacesBounce) {
        auto glow = std::make_shared<const ShellGlow>(scene.instances);
        scene.glow = glow->empty() ? nullptr : std::move(glow);
    }
    report.indirectSeconds += since(start);
    cores_.dropUnused();
    samplings_.dropUnused();
    return report;
}

} // namespace stf
