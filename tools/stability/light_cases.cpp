// SPDX-License-Identifier: Apache-2.0
// Point 8: linearity and scaling.
#include "tools/stability/small_scene.h"

#include <cmath>

namespace stf {

namespace {

// Shell, core, a sun and a lamp: all that light goes through.
SmallScene litScene(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    scene.setLightCosine(0.7);
    Light lamp;
    lamp.type = Light::Type::Sphere;
    lamp.radius = 2;
    lamp.emission = Rgb(20, 10, 5);
    lamp.lightToWorld.translation = {6, 0, 12};
    scene.lights["/lamp"] = lamp;
    scene.lights["/sky"].type = Light::Type::Dome;
    scene.lights["/sky"].emission = Rgb(0.3f);
    return scene;
}

SmallPicture times(StabilityRun& run, float factor) {
    SmallScene scene = litScene(run);
    for (auto& [id, l] : scene.lights) {
        l.emission = l.emission * factor;
    }
    return scene.render();
}

StabilityOutcome twice(StabilityRun& run) {
    SmallPicture one = times(run, 1);
    const SmallPicture two = times(run, 2);
    for (std::size_t i = 0; i < one.color.size(); ++i) {
        one.color[i] *= i % 4 == 3 ? 1.0f : 2.0f;
    }
    const double off = largestDifference(two, one);
    return {
        measuredText("largest difference from twice the picture %.1e, radiance up to %.3f", off, double(two.largest())),
        two.finite() && off < 1e-6 && two.largest() > 0};
}

StabilityOutcome intensities(StabilityRun& run) {
    const SmallPicture one = times(run, 1);
    double worst = 0;
    for (const float f : {1e-30f, 1e30f}) {
        SmallPicture p = times(run, f);
        if (!p.finite()) {
            return {measuredText("not finite at intensity %g", double(f)), false};
        }
        for (std::size_t i = 0; i < p.color.size(); ++i) {
            p.color[i] /= i % 4 == 3 ? 1.0f : f;
        }
        worst = std::max(worst, largestDifference(p, one));
    }
    return {measuredText("scaled back, they differ by %.1e", worst), worst < 1e-5};
}

StabilityOutcome darkness(StabilityRun& run) {
    const SmallPicture p = times(run, 0);
    return {measuredText("largest radiance %g", double(p.largest())), p.finite() && p.largest() == 0};
}

// Red becomes green, green blue, blue red.
Rgb permuted(const Rgb& c) {
    return {c.z, c.x, c.y};
}

StabilityOutcome channels(StabilityRun& run) {
    const auto coloured = [&](bool permute) {
        SmallScene scene = litScene(run);
        const auto turn = [&](const Rgb& c) { return permute ? permuted(c) : c; };
        scene.settings.quality = 0.02f;
        scene.volume.extinction.assign(scene.volume.voxelCount(), turn({0.5f, 1, 3}));
        scene.volume.albedo.assign(scene.volume.voxelCount(), turn({0.99f, 0.9f, 0.6f}));
        scene.binding.coreSigmaA = turn({0.1f, 0.2f, 0.9f});
        scene.binding.coreSigmaSPrime = turn({0.9f, 1, 0.3f});
        for (auto& [id, l] : scene.lights) {
            l.emission = turn(l.emission * Rgb(1, 0.5f, 0.25f));
        }
        return scene.render();
    };
    SmallPicture expected = coloured(false);
    const SmallPicture p = coloured(true);
    for (std::size_t i = 0; i < expected.color.size(); i += 4) {
        const Rgb c = permuted({expected.color[i], expected.color[i + 1], expected.color[i + 2]});
        for (int k = 0; k < 3; ++k) {
            expected.color[i + std::size_t(k)] = c[k];
        }
    }
    const double rms = rmsDifference(p, expected);
    return {measuredText("the permuted picture differs by %.2e rms, tables good to %.1e", rms, p.tableError),
            p.finite() && rms < 0.03};
}

// The scene written in other units: all lengths times s, metersPerUnit over s.
StabilityOutcome units(StabilityRun& run, double s) {
    SmallScene scene = litScene(run);
    const SmallPicture here = scene.render();
    scene.unitsPerMm = s;
    for (auto& [id, l] : scene.lights) {
        l.lightToWorld.translation = l.lightToWorld.translation * s;
        l.radius *= float(s);
    }
    const SmallPicture there = scene.render();
    const double off = largestDifference(there, here);
    return {measuredText("largest difference %.1e; %s", off,
                         there.messages.empty() ? "nothing was said" : there.messages[0].c_str()),
            there.finite() && off < 2e-3};
}

// The same by the transform of the instance.
StabilityOutcome transformed(StabilityRun& run, double s) {
    SmallScene scene(run);
    scene.setCore(0.9);
    scene.setLightCosine(0.7);
    const SmallPicture here = scene.render();
    Transform& t = scene.instances[0].objectToWorld;
    t.x = t.x * s;
    t.y = t.y * s;
    t.z = t.z * s;
    scene.viewMm *= s;
    // The camera looks from 100 mm: far enough for any of these.
    const SmallPicture there = scene.render();
    const double off = largestDifference(there, here);
    return {measuredText("largest difference %.1e", off), there.finite() && off < 2e-3};
}

// Voxels s times as large and coefficients over s: the same optical depths.
StabilityOutcome dilated(StabilityRun& run) {
    double worst = 0;
    SmallScene scene(run);
    scene.setCore(0.9);
    const SmallPicture here = scene.render();
    for (const double s : {1e-6, 1e6}) {
        SmallScene big(run);
        big.volume.voxelMm = big.volume.voxelMm * s;
        for (Rgb& k : big.volume.extinction) {
            k = Rgb(Vec3d(k) / s);
        }
        big.binding.coreSigmaA = Rgb(float(0.1 / s));
        big.binding.coreSigmaSPrime = Rgb(float(0.9 / s));
        big.binding.scale = float(1 / s); // as large in the scene as before
        const SmallPicture p = big.render();
        const double off = p.finite() ? std::abs(p.mean().y / here.mean().y - 1) : INFINITY;
        worst = std::max(worst, off);
    }
    return {
        measuredText("mean radiance differs by %.2f %%, tables good to %.2f %%", 100 * worst, 100 * here.tableError),
        worst < 0.01};
}

StabilityOutcome farAway(StabilityRun& run) {
    SmallScene scene = litScene(run);
    const SmallPicture here = scene.render();
    const Vec3d far{1e6, -2e6, 5e5};
    scene.instances[0].objectToWorld.translation = far;
    scene.lookAt = far;
    scene.lights["/lamp"].lightToWorld.translation += far;
    const SmallPicture there = scene.render();
    const double off = largestDifference(there, here);
    return {measuredText("largest difference %.1e", off), there.finite() && off < 2e-3};
}

} // namespace

void addLightCases(std::vector<StabilityCase>& all) {
    all.push_back({"8.light-doubled", "sun, lamp and sky of twice the intensity, shell over core",
                   "twice the picture within 1e-6", false, false, twice});
    all.push_back({"8.light-0", "all lights of intensity 0", "exactly black", false, false, darkness});
    all.push_back({"8.light-1e-30-1e30", "all lights of 1e-30 and 1e30 times the intensity",
                   "finite; scaled back the same picture within 1e-5", false, false, intensities});
    all.push_back({"8.channels", "red, green and blue of medium, core and lights change places",
                   "so do those of the picture, within 3 % rms (the tables' errors)", false, false, channels});
    all.push_back({"8.units-1e-6", "all lengths of the scene in units 1e6 times as large", "the same picture, 2e-3",
                   false, false, [](StabilityRun& run) { return units(run, 1e-6); }});
    all.push_back({"8.units-1e6", "all lengths of the scene in units a millionth as large", "the same picture, 2e-3",
                   false, false, [](StabilityRun& run) { return units(run, 1e6); }});
    all.push_back({"8.instance-1e-3", "an instance scaled by 1e-3, seen from as much nearer", "the same picture, 2e-3",
                   false, false, [](StabilityRun& run) { return transformed(run, 1e-3); }});
    all.push_back({"8.instance-1e3", "an instance scaled by 1e3, seen as much wider", "the same picture, 2e-3", false,
                   false, [](StabilityRun& run) { return transformed(run, 1e3); }});
    all.push_back({"8.dilated", "voxels of 1e-6 and 1e6 times the size, coefficients over as much",
                   "the same mean radiance within 1 %", false, false, dilated});
    all.push_back(
        {"8.offset-1e6", "the scene moved by (1e6, -2e6, 5e5) units", "the same picture, 2e-3", false, false, farAway});
}

} // namespace stf
