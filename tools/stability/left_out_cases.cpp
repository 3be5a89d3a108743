// SPDX-License-Identifier: Apache-2.0
// Stages that a frame does not need are left out, and the picture is the one with them; edits redo what they touch.
#include "stfLib/cache/map_cache.h"
#include "stfLib/cache/table_cache.h"
#include "tools/stability/small_scene.h"

#include <cmath>

namespace stf {

namespace {

const char* ran(bool runs) {
    return runs ? "runs" : "left out";
}

StabilityOutcome noScattering(StabilityRun& run) {
    SmallScene scene(run);
    scene.volume = uniformVolume(1, 0, 0, 8, 2);
    scene.setCore(0.9);
    const SmallPicture without = scene.render();
    scene.volume = uniformVolume(1, 1e-6, 0, 8, 2);
    const SmallPicture with = scene.render();
    const double off = largestDifference(with, without);
    return {measuredText("albedo 0: %s; albedo 1e-6: %s, differs by %.1e", ran(without.entry("transport").runs),
                         ran(with.entry("transport").runs), off),
            !without.entry("transport").runs && with.entry("transport").runs && off < 1e-5 && without.largest() > 0};
}

StabilityOutcome blackCore(StabilityRun& run) {
    SmallScene scene(run);
    const auto coreRuns = [](const SmallPicture& p) {
        bool any = false;
        for (const PlanEntry& e : p.plan) {
            any = any || (e.stage == "core" && e.runs);
        }
        return any;
    };
    scene.setCore(0);
    const SmallPicture without = scene.render();
    scene.setCore(1e-7);
    const SmallPicture with = scene.render();
    scene.setCore(0.9);
    scene.binding.coreModel = "none";
    const SmallPicture none = scene.render();
    const double off = largestDifference(with, without), same = largestDifference(none, without);
    return {measuredText("black: %s; sigma_s' 1e-7: %s, differs by %.1e; coreModel none: %s, differs by %.1e",
                         ran(coreRuns(without)), ran(coreRuns(with)), off, ran(coreRuns(none)), same),
            !coreRuns(without) && coreRuns(with) && off < 1e-5 && !coreRuns(none) && same == 0};
}

StabilityOutcome darkCore(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    scene.lights.clear();
    const SmallPicture p = scene.render();
    bool solved = false;
    for (const PlanEntry& e : p.plan) {
        solved = solved || (e.object == "scene" && e.stage == "core" && e.runs);
    }
    return {measuredText("core: %s, largest radiance %g", ran(solved), double(p.largest())),
            !solved && p.largest() == 0};
}

// A plain square and an invisible object with a shell: nothing of the shell runs.
StabilityOutcome invisible(StabilityRun& run) {
    SmallScene scene(run);
    ControlMesh wall = squareMesh();
    wall.colors = {Rgb(0.5f, 0.3f, 0.1f)};
    scene.plain["/wall"] = wall;
    scene.visible = false;
    const SmallPicture hidden = scene.render();
    scene.bound = false;
    const SmallPicture unbound = scene.render();
    const bool same = hidden.color == unbound.color;
    return {measuredText("tables asked for: %d, grids %d; the picture without the binding is %s", hidden.tables,
                         hidden.stats.grids, same ? "equal" : "different"),
            same && hidden.tables == 0 && hidden.stats.grids == 0 && hidden.stats.refinements == 0 &&
                hidden.largest() > 0};
}

StabilityOutcome unbound(StabilityRun& run) {
    SmallScene scene(run);
    scene.bound = false;
    scene.mesh.colors = {Rgb(0.5f)};
    const SmallPicture p = scene.render();
    bool any = false;
    for (const char* stage : {"load", "transport", "synthesis", "shell", "core"}) {
        any = any || p.entry(stage).runs;
    }
    return {
        measuredText("stages of shells: %s, tables %d; radiance %.5f (Lambert's .5)", ran(any), p.tables, p.mean().y),
        !any && p.tables == 0 && p.messages.empty() && std::abs(p.mean().y - 0.5) < 1e-4};
}

// A flat square is the same however it is subdivided.
StabilityOutcome noSubdivision(StabilityRun& run) {
    SmallScene scene(run);
    scene.bound = false;
    scene.mesh.colors = {Rgb(0.5f)};
    const SmallPicture plain = scene.render();
    scene.mesh.scheme = ControlMesh::Scheme::Bilinear;
    const SmallPicture refined = scene.render();
    scene.mesh.scheme = ControlMesh::Scheme::None;
    scene.bound = true;
    const SmallPicture shell = scene.render();
    scene.mesh.scheme = ControlMesh::Scheme::Bilinear;
    const SmallPicture shellRefined = scene.render();
    const double off = largestDifference(refined, plain);
    const double shellOff = std::abs(shellRefined.mean().y / shell.mean().y - 1);
    return {measuredText("scheme none and bilinear differ by %.1e; with a shell by %.1e in the mean", off, shellOff),
            off < 1e-5 && shellOff < 2e-3};
}

StabilityOutcome noLight(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    const SmallPicture one = scene.render();
    Light other = scene.light();
    other.lightToWorld.z = {0.6, 0, 0.8};
    other.visible = false;
    scene.lights["/other"] = other;
    const SmallPicture hidden = scene.render();
    scene.lights["/other"].visible = true;
    scene.lights["/other"].emission = Rgb(0.0f);
    const SmallPicture black = scene.render();
    const bool same = hidden.color == one.color && black.color == one.color;
    return {measuredText("invisible: %s, black: %s; %s", hidden.color == one.color ? "equal" : "different",
                         black.color == one.color ? "equal" : "different", black.entry("lights").why.c_str()),
            same && black.entry("lights").why.rfind("1 of 2", 0) == 0};
}

StabilityOutcome noFresnel(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    const SmallPicture without = scene.render();
    scene.volume.ior.assign(scene.volume.voxelCount(), 1.0f);
    const SmallPicture written = scene.render();
    scene.volume.ior.assign(scene.volume.voxelCount(), 1 + 1e-6f);
    const SmallPicture with = scene.render();
    const double off = std::abs(with.mean().y / without.mean().y - 1);
    return {measuredText("index 1: %s; written out: picture %s; 1 + 1e-6: %s, mean differs by %.2f %%",
                         ran(without.entry("fresnel").runs), written.color == without.color ? "equal" : "different",
                         ran(with.entry("fresnel").runs), 100 * off),
            !without.entry("fresnel").runs && written.color == without.color && with.entry("fresnel").runs &&
                off < 0.03};
}

StabilityOutcome fromTheStore(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    scene.settings.quality = 0.021f; // of its own
    // A sample that is laid out by example.
    scene.mesh.uvs.clear();
    scene.mesh.uvIndices.clear();
    BaseVolume& v = scene.volume;
    v.size = {16, 16, 4};
    v.voxelMm = Vec3d(0.5);
    v.g.clear();
    v.extinction.assign(v.voxelCount(), Rgb(1.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.9f));
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.albedo[i] = Rgb(i % 5 < 2 ? 0.6f : 0.95f);
    }
    scene.settings.quality = 0.2f;
    const auto picture = [&] {
        const std::string folder = run.folder.file("store");
        Renderer renderer(cachedTables(folder), cachedMaps(folder));
        Scene source;
        scene.fill(source);
        return scene.render(renderer, source);
    };
    const SmallPicture made = picture(), read = picture();
    const bool same = made.color == read.color;
    return {measuredText("first: transport %s, synthesis %s; then %s, %s; pictures %s",
                         ran(made.entry("transport").runs), ran(made.entry("synthesis").runs),
                         ran(read.entry("transport").runs), ran(read.entry("synthesis").runs),
                         same ? "equal" : "different"),
            same && made.entry("transport").runs && made.entry("synthesis").runs && !read.entry("transport").runs &&
                !read.entry("synthesis").runs && made.largest() > 0};
}

StabilityOutcome noBounces(StabilityRun& run) {
    SmallScene scene(run);
    scene.setDome(1);
    scene.setCore(0.9);
    scene.settings.maxDepth = 1;
    const SmallPicture none = scene.render();
    scene.settings.maxDepth = 8;
    const SmallPicture many = scene.render();
    return {measuredText("up to 8 bounces: %s, picture %s", ran(many.entry("bounces").runs),
                         many.color == none.color ? "equal" : "different"),
            !many.entry("bounces").runs && many.color == none.color && none.largest() > 0};
}

StabilityOutcome noLens(StabilityRun& run) {
    const SmallScene scene(run);
    Scene source;
    scene.fill(source);
    const auto picture = [&](double radius) {
        int asked = 0;
        double error = 0;
        const auto renderer = makeRenderer(asked, error);
        renderer->setSettings(scene.settings);
        const Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1};
        const Matrix4 projection{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.002, -1, 0, 0, -0.2, 0};
        CameraOptics optics;
        optics.lens = {radius, 5};
        renderer->setCamera(Camera(view, projection, optics), scene.size, scene.size);
        renderer->prepare(source, scene.run.progress);
        renderer->restart();
        while (!renderer->converged()) {
            renderer->renderPass(scene.run.progress);
        }
        bool lens = false;
        for (const PlanEntry& e : renderer->plan()) {
            lens = lens || (e.stage == "lens" && e.runs);
        }
        SmallPicture p;
        p.color = renderer->film().read(Aov::Color);
        return std::make_pair(p, lens);
    };
    const auto none = picture(0), tiny = picture(1e-9);
    const double off = std::abs(tiny.first.mean().y / none.first.mean().y - 1);
    const double noise = 4 * (tiny.first.error() + none.first.error()) / none.first.mean().y;
    return {measuredText("radius 0: %s; 1e-9: %s, mean differs by %.2e, noise %.2e", ran(none.second), ran(tiny.second),
                         off, noise),
            !none.second && tiny.second && off < noise};
}

// What a renderer did so far.
struct Done {
    int tables, refinements, syntheses, grids;
    double core;
    bool operator==(const Done& d) const {
        return tables == d.tables && refinements == d.refinements && syntheses == d.syntheses && grids == d.grids &&
               core == d.core;
    }
    std::string text() const {
        return measuredText("%d tables, %d surfaces, %d syntheses, %d grids", tables, refinements, syntheses, grids);
    }
};

StabilityOutcome edits(StabilityRun& run) {
    SmallScene scene(run);
    scene.setCore(0.9);
    scene.mesh.uvs.clear();
    scene.mesh.uvIndices.clear();
    BaseVolume& v = scene.volume;
    v.size = {16, 16, 4};
    v.voxelMm = Vec3d(0.5);
    v.g.clear();
    v.extinction.assign(v.voxelCount(), Rgb(1.0f));
    v.albedo.assign(v.voxelCount(), Rgb(0.9f));
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.albedo[i] = Rgb(i % 7 < 2 ? 0.6f : 0.95f);
    }
    scene.settings.quality = 0.2f;
    int asked = 0;
    double error = 0;
    const auto renderer = makeRenderer(asked, error);
    Scene source;
    scene.fill(source);
    const auto state = [&] {
        scene.render(*renderer, source);
        const RenderStats s = renderer->stats();
        return Done{asked, s.refinements, s.syntheses, s.grids, s.coreSeconds};
    };
    const Done first = state();
    scene.lookAt = {1, 1, 0};
    scene.viewMm = 3;
    const Done camera = state();
    scene.setLightCosine(0.5);
    source.setLight("/light", scene.light());
    const Done light = state();
    const std::vector<float> lit = renderer->film().read(Aov::Color);
    const bool fresh = scene.render().color == lit;
    scene.instances[0].objectToWorld.translation = {0, 0, -1};
    source.setInstances("/object", scene.instances);
    const Done moved = state();
    StfBinding binding = *source.meshes().at("/object").stf;
    binding.seed = 7;
    source.setStf("/object", binding);
    const Done seed = state();
    binding.quality = 0.15f;
    source.setStf("/object", binding);
    const Done quality = state();
    const bool ok = camera == first && light.tables == 1 && light.grids == 1 && light.syntheses == 1 &&
                    light.refinements == first.refinements && light.core > camera.core && fresh && moved.tables == 1 &&
                    moved.grids == 1 && moved.syntheses == 1 && seed.tables == 1 && seed.syntheses == 2 &&
                    seed.grids == 2 && seed.refinements == first.refinements && quality.tables == 2 &&
                    quality.syntheses == 2 && quality.grids == 2;
    return {"first " + first.text() + "; camera " + (camera == first ? "nothing" : camera.text()) + "; light, place " +
                (moved.tables == 1 && moved.grids == 1 ? "core alone" : moved.text()) + "; seed " + seed.text() +
                "; quality " + quality.text() + (fresh ? "" : "; a fresh renderer differs"),
            ok};
}

} // namespace

void addLeftOutCases(std::vector<StabilityCase>& all) {
    all.push_back({"plan.no-scattering", "albedo 0: no walks", "albedo 1e-6, with walks, differs by less than 1e-5",
                   false, false, noScattering});
    all.push_back({"plan.black-core", "a core that does not scatter: nothing is solved",
                   "sigma_s' 1e-7, solved, differs by less than 1e-5; coreModel none is equal", false, false,
                   blackCore});
    all.push_back({"plan.no-light", "no light at all: no core is solved", "black", false, false, darkCore});
    all.push_back({"plan.invisible", "an invisible object with a shell before a plain wall",
                   "no table, surface or grid is made, the picture is equal", false, false, invisible});
    all.push_back(
        {"plan.unbound", "an object without a shell", "no stage of shells runs; Lambert's law", false, false, unbound});
    all.push_back({"plan.no-subdivision", "a square of scheme none: no subdivision",
                   "bilinear subdivision differs by less than 1e-5, with a shell 2e-3 in the mean", false, false,
                   noSubdivision});
    all.push_back({"plan.dark-light", "an invisible light, a light of intensity 0: no direction",
                   "the picture is equal, the plan counts 1 of 2", false, false, noLight});
    all.push_back({"plan.index-1", "index 1: no Fresnel",
                   "index 1 written out is equal; 1 + 1e-6, refracted, is within 3 % (the tables' error)", false, false,
                   noFresnel});
    all.push_back({"plan.from-the-store", "tables and layouts kept from an earlier run: read",
                   "neither runs, the picture is equal", false, false, fromTheStore});
    all.push_back(
        {"plan.no-bounces", "no plain surface: no bounces", "1 and 8 bounces are equal", false, false, noBounces});
    all.push_back({"plan.no-lens", "a lens of radius 0: a pinhole", "radius 1e-9 agrees within 4 standard errors",
                   false, false, noLens});
    all.push_back({"plan.edits", "camera, light, place, seed of the layout, quality are changed one after the other",
                   "camera: nothing; light and place: the core; seed: layout and grid; quality: the table", false,
                   false, edits});
}

} // namespace stf
