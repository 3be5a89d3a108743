// SPDX-License-Identifier: Apache-2.0
// Points 12 and 13: threads, restarts, and how errors fall.
#include "stfLib/base/parallel.h"
#include "stfLib/optics/h_function.h"
#include "stfLib/transport/precompute.h"
#include "tools/stability/small_scene.h"

#include <cmath>

namespace stf {

namespace {

// As many kinds of random numbers as there are: sky, lamp, core, index, a table.
SmallScene noisyScene(StabilityRun& run) {
    SmallScene scene(run);
    scene.volume.ior.assign(scene.volume.voxelCount(), 1.4f);
    scene.setCore(0.9);
    scene.setDome(0.5f);
    scene.lights["/lamp"].type = Light::Type::Sphere;
    scene.lights["/lamp"].radius = 3;
    scene.lights["/lamp"].emission = Rgb(10.0f);
    scene.lights["/lamp"].lightToWorld.translation = {5, 0, 9};
    scene.settings.quality = 0.1f;
    scene.settings.samples = 8;
    return scene;
}

/// Sets the number of threads and puts it back.
class Threads {
public:
    explicit Threads(int threads) : before_(threadCount()) { setThreadCount(threads); }
    ~Threads() { setThreadCount(before_); }

private:
    int before_;
};

StabilityOutcome threads(StabilityRun& run) {
    const Threads restore(0);
    SmallScene scene = noisyScene(run);
    std::vector<std::vector<float>> pictures;
    for (const int n : {1, 2, 3, 7}) {
        scene.settings.threads = n;
        pictures.push_back(scene.render().color);
    }
    scene.settings.threads = 0;
    scene.settings.seed = 1;
    const bool other = scene.render().color != pictures[0];
    const bool same = pictures[1] == pictures[0] && pictures[2] == pictures[0] && pictures[3] == pictures[0];
    return {measuredText("1, 2, 3, 7 threads: %s; another seed: %s", same ? "equal" : "different",
                         other ? "different" : "equal"),
            same && other};
}

StabilityOutcome tableThreads(StabilityRun& run) {
    BaseVolume v = uniformVolume(2, 0.95, 0.6, 6, 2);
    v.size = {6, 6, 6};
    v.voxelMm = Vec3d(0.3);
    v.extinction.assign(v.voxelCount(), Rgb(1.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.95f));
    v.g.assign(v.voxelCount(), 0.6f);
    for (std::size_t i = 0; i < v.voxelCount(); i += 3) {
        v.extinction[i] = Rgb(4.0f);
    }
    TransportOptions options;
    options.quality = 0.1f;
    std::vector<StfTable> tables;
    for (const int n : {1, 2, 5}) {
        const Threads scope(n);
        tables.push_back(precompute(v, options, run.progress, {}));
    }
    bool same = true;
    for (const StfTable& t : tables) {
        same = same && t.multiple->factors == tables[0].multiple->factors &&
               t.multiple->basis == tables[0].multiple->basis &&
               t.transmitted->factors == tables[0].transmitted->factors &&
               t.backlight->factors == tables[0].backlight->factors && t.photons == tables[0].photons;
    }
    return {measuredText("1, 2, 5 threads: %s; %d photons, rank %d", same ? "equal" : "different",
                         int(tables[0].photons), tables[0].multiple->rank),
            same && tables[0].photons > 0 && !tables[0].multiple->empty()};
}

StabilityOutcome restarts(StabilityRun& run) {
    const SmallScene scene = noisyScene(run);
    int asked = 0;
    double error = 0;
    const auto renderer = makeRenderer(asked, error);
    Scene source;
    scene.fill(source);
    const std::vector<float> first = scene.render(*renderer, source).color;
    const std::vector<float> again = scene.render(*renderer, source).color;
    // Interrupted after three passes, taken up again.
    renderer->restart();
    Progress stopped, going;
    stopped.cancel();
    for (int pass = 0; pass < 3; ++pass) {
        renderer->renderPass(going);
    }
    const bool interrupted = !renderer->renderPass(stopped);
    while (!renderer->converged()) {
        renderer->renderPass(going);
    }
    const std::vector<float> resumed = renderer->film().read(Aov::Color);
    const std::vector<float> fresh = scene.render().color;
    return {measuredText("again: %s, interrupted: %s, another renderer: %s", again == first ? "equal" : "different",
                         resumed == first ? "equal" : "different", fresh == first ? "equal" : "different"),
            again == first && interrupted && resumed == first && fresh == first};
}

StabilityOutcome manySamples(StabilityRun& run) {
    SmallScene scene(run);
    scene.settings.samples = 4096;
    scene.size = 4;
    const SmallPicture many = scene.render();
    // Each pixel shows the same; 16 independent sums agree as well as their noise lets them.
    scene.settings.seed = 1;
    const SmallPicture other = scene.render();
    const double off = std::abs(many.mean().y / other.mean().y - 1);
    const double noise = 4 * std::hypot(many.error(), other.error()) / many.mean().y;
    return {measuredText("two seeds differ by %.1e, noise of each %.1e", off, many.error() / many.mean().y),
            off < noise + 1e-6 && noise < 1e-2};
}

// Error of 4^k samples against many, over pixels and seeds.
StabilityOutcome slope(StabilityRun& run) {
    SmallScene scene(run);
    scene.setDome(1);
    scene.settings.quality = 0.1f;
    scene.size = 16;
    scene.settings.seed = 1000;
    scene.settings.samples = 1024;
    const double exact = scene.render().mean().y;
    std::vector<double> rmse;
    for (const int samples : {4, 16, 64, 256}) {
        scene.settings.samples = samples;
        double squares = 0;
        for (const std::uint64_t seed : {1, 2}) {
            scene.settings.seed = seed;
            const SmallPicture p = scene.render();
            for (std::size_t i = 1; i < p.color.size(); i += 4) {
                squares += std::pow(double(p.color[i]) - exact, 2);
            }
        }
        rmse.push_back(std::sqrt(squares / 512) / exact);
    }
    const double s = std::log(rmse.back() / rmse.front()) / std::log(64.0);
    return {measuredText("errors %.2f %.2f %.2f %.2f %%, slope %.2f", 100 * rmse[0], 100 * rmse[1], 100 * rmse[2],
                         100 * rmse[3], s),
            s < -0.45};
}

// Radiance of a half space in closed form (Chandrasekhar 1960), by ever thinner layers.
StabilityOutcome resolution(StabilityRun& run) {
    const HFunction h(0.1);
    const double mu = 0.5, exact = 0.9 * h(mu) * h(1) / (4 * (mu + 1)); // irradiance pi
    std::vector<double> off;
    std::string text = "errors of layers of 1, 1/2, 1/4, 1/8 mean free paths:";
    for (const int perPath : {1, 2, 4, 8}) {
        SmallScene scene(run);
        scene.volume = uniformVolume(12, 0.9, 0, 12 * perPath, 12);
        scene.settings.quality = 0.004f;
        scene.settings.samples = 256;
        scene.viewCosine = mu;
        const SmallPicture p = scene.render();
        off.push_back(p.mean().y / exact - 1);
        text += measuredText(" %+.2f", 100 * off.back());
    }
    text += " %";
    return {text, std::abs(off[1]) < 0.6 * std::abs(off[0]) && std::abs(off[3]) < 0.01 &&
                      std::abs(off[3]) < 0.25 * std::abs(off[0])};
}

} // namespace

void addRepeatCases(std::vector<StabilityCase>& all) {
    all.push_back({"12.threads", "1, 2, 3, 7 threads: sky, lamp, index 1.4, core", "the same picture, bit for bit",
                   false, false, threads});
    all.push_back(
        {"12.table-threads", "a table by 1, 2, 5 threads", "the same table, bit for bit", false, false, tableThreads});
    all.push_back({"12.restart", "rendered again, interrupted and resumed, by another renderer",
                   "the same picture, bit for bit", false, false, restarts});
    all.push_back({"12.many-samples", "4096 samples a pixel with two seeds", "they agree within 4 standard errors",
                   true, false, manySamples});
    all.push_back({"13.slope", "4 to 256 samples a pixel under a sky", "the error falls with slope -.45 or steeper",
                   true, false, slope});
    all.push_back({"13.resolution", "a half space in layers of 1 to 1/8 mean free paths, seen at 60 degrees",
                   "the bias falls by more than .6 from 1 to 1/2 and to less than 1 %", true, false, resolution});
}

} // namespace stf
