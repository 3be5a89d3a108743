// SPDX-License-Identifier: Apache-2.0
// Points 3 and 6: stiff media and furnaces, rendered.
#include "stfLib/optics/h_function.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/transport/walk.h"
#include "tools/stability/small_scene.h"
#include "tools/stf/slab_stf.h"

#include <cmath>

namespace stf {

namespace {

StabilityOutcome emptyShell(StabilityRun& run) {
    SmallScene scene(run);
    scene.volume = uniformVolume(0, 0, 0, 4, 2);
    scene.setCore(0.9);
    const SmallPicture p = scene.render();
    const double exact = HFunction(0.1).reflectance(1), off = p.mean().y / exact - 1;
    return {measuredText("radiance %.6f, core alone %.6f: %+.2f %%", p.mean().y, exact, 100 * off),
            p.finite() && std::abs(off) < 0.005};
}

// How much light there is, and what a white core under it changes.
StabilityOutcome opaque(StabilityRun& run, double tau, double albedo) {
    SmallScene scene(run);
    scene.volume = uniformVolume(tau, albedo, 0, 4, 2);
    scene.settings.quality = 0.1f;
    const SmallPicture black = scene.render();
    scene.setCore(1);
    const SmallPicture white = scene.render();
    const double leak = largestDifference(white, black), most = double(white.largest());
    return {measuredText("largest radiance %.4f, a white core below changes %.1e", most, leak),
            black.finite() && white.finite() && leak < 1e-6 && (albedo > 0 ? most > 0 && most < 1.5 : most == 0)};
}

BaseVolume checkered(float strongest) {
    BaseVolume v = uniformVolume(1, 0.9, 0, 6, 3);
    v.size = {4, 4, 6};
    v.extinction.assign(v.voxelCount(), Rgb(0.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.9f));
    for (int z = 0; z < 6; ++z) {
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 4; ++x) {
                const float k = (x + y + z) % 2 ? strongest : z % 3 ? 0.0f : 1e-3f;
                v.extinction[v.index(x, y, z)] = Rgb(z == 4 ? strongest : k); // one layer has no gaps
            }
        }
    }
    return v;
}

StabilityOutcome voidsBesideOpaque(StabilityRun& run) {
    SmallScene scene(run);
    scene.volume = checkered(1e6f);
    scene.tables = [](const std::shared_ptr<const BaseVolume>& volume, TransportOptions options, Progress& progress,
                      const MessageSink& messages) {
        options.maxPhotons = 20'000;
        return std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
    };
    scene.setLightCosine(0.7);
    const SmallPicture black = scene.render();
    scene.setCore(1);
    const SmallPicture white = scene.render();
    const TileMedium medium(scene.volume, TransportForm::DE1);
    WalkRequest request;
    request.count = 5000;
    request.voxels = false;
    request.scalar = true; // side by side, by null collisions, voids cost far more
    WalkSource source;
    source.kind = WalkSource::Kind::DiffuseTop;
    const WalkTally t = walk(medium, source, request, run.progress);
    double below = 0;
    for (const auto* part : {&t.below, &t.belowUncollided}) {
        for (double w : *part) {
            below += w;
        }
    }
    const double leak = largestDifference(white, black);
    return {measuredText("a white core changes %.1e, walks bring %.1e below; largest radiance %.3f", leak, below,
                         double(white.largest())),
            black.finite() && white.finite() && leak < 1e-6 && below == 0 && t.lost == 0 && white.largest() > 0};
}

// Light from everywhere, nothing absorbed: radiance 1 everywhere.
SmallPicture furnace(StabilityRun& run, double ior, double g, double albedo, double viewCosine,
                     const std::string& transport = {}) {
    SmallScene scene(run);
    scene.volume = uniformVolume(2, albedo, g, 20, 2);
    if (ior != 1) {
        scene.volume.ior.assign(scene.volume.voxelCount(), float(ior));
    }
    scene.binding.transport = transport;
    scene.setDome(1);
    scene.setCore(1);
    scene.settings.quality = 0.01f;
    scene.settings.samples = 128;
    scene.viewCosine = viewCosine;
    return scene.render();
}

StabilityOutcome whiteFurnace(StabilityRun& run, double ior, double g) {
    double worst = 0, noise = 0;
    bool ok = true;
    for (const double mu : {1.0, 0.4}) {
        const SmallPicture p = furnace(run, ior, g, 1, mu);
        const double off = p.mean().y - 1;
        worst = std::abs(off) > std::abs(worst) ? off : worst;
        noise = std::max(noise, p.error());
        ok = ok && p.finite() && std::abs(off) < 0.01 + 3 * p.error() + p.tableError;
    }
    return {measuredText("radiance 1 %+.2f %%, noise %.2f %%", 100 * worst, 100 * noise), ok && noise < 0.005};
}

StabilityOutcome nearlyWhiteScene(StabilityRun& run) {
    const SmallPicture p = furnace(run, 1.3, 0, 1 - 1e-7, 1);
    return {measuredText("radiance %.5f, noise %.5f", p.mean().y, p.error()),
            p.finite() && std::abs(p.mean().y - 1) < 0.01 + 3 * p.error() + p.tableError};
}

StabilityOutcome greyFurnace(StabilityRun& run) {
    double last = -1;
    bool grows = true;
    std::string text = "radiance by albedo:";
    for (const double albedo : {0.0, 0.5, 0.9, 0.99, 0.999}) {
        const double l = furnace(run, 1, 0, albedo, 1).mean().y;
        grows = grows && l > last && l < 1;
        text += measuredText(" %.4f", l);
        last = l;
    }
    return {text, grows};
}

StabilityOutcome classicFurnace(StabilityRun& run) {
    const SmallPicture p = furnace(run, 1, 0.8, 1, 1, "classic");
    const double off = p.mean().y - 1;
    return {measuredText("radiance 1 %+.1f %%", 100 * off), p.finite() && std::abs(off) < 0.15};
}

} // namespace

void addSceneCases(std::vector<StabilityCase>& all) {
    all.push_back({"3.empty-shell", "a shell of optical depth 0 over a core of albedo .9",
                   "the core's own radiance within .5 %", false, false, emptyShell});
    all.push_back({"3.tau-1e6-black", "a shell of optical depth 1e6, albedo 0, over a white core", "exactly black",
                   false, false, [](StabilityRun& run) { return opaque(run, 1e6, 0); }});
    all.push_back({"3.tau-1e6-white", "a shell of optical depth 1e6, albedo .99, over a white core",
                   "finite, no light of the core (1e-6)", false, false,
                   [](StabilityRun& run) { return opaque(run, 1e6, 0.99); }});
    all.push_back({"3.tau-1e4-white", "a shell of optical depth 1e4, albedo .9, over a white core",
                   "finite, no light of the core (1e-6)", false, false,
                   [](StabilityRun& run) { return opaque(run, 1e4, 0.9); }});
    all.push_back({"3.voids-beside-opaque", "voids and 1e-3/mm beside voxels of 1e6/mm, one such layer without gaps",
                   "finite; nothing comes through the layer, by walks (0) and in the picture (1e-6)", false, false,
                   voidsBesideOpaque});

    for (const double ior : {1.0, 1.3, 1.5}) {
        all.push_back({"6.white-furnace-n" + measuredText("%g", ior),
                       "albedo 1 over a white core in uniform light, index " + measuredText("%g", ior) +
                           ", seen at cosine 1 and .4",
                       "radiance 1 within 1 %, the tables' error and 3 standard errors", ior == 1.3, false,
                       [ior](StabilityRun& run) { return whiteFurnace(run, ior, 0); }});
    }
    all.push_back({"6.white-furnace-g.8", "the same with g .8, index 1, dE1", "radiance 1 within the same bounds", true,
                   false, [](StabilityRun& run) { return whiteFurnace(run, 1, 0.8); }});
    all.push_back({"6.albedo-1-1e-7", "a furnace of albedo 1 - 1e-7, index 1.3, rendered",
                   "radiance 1 within 1 %, the tables' error and 3 standard errors", false, false, nearlyWhiteScene});
    all.push_back({"6.grey-furnace", "albedo 0, .5, .9, .99, .999 in uniform light", "radiance below 1 and growing",
                   true, false, greyFurnace});
    all.push_back({"6.classic-furnace", "the published form (classic), albedo 1, g .8",
                   "known limit: isotropic multiple scattering does not conserve energy where g is not 0, 15 %", true,
                   true, classicFurnace});
}

} // namespace stf
