// SPDX-License-Identifier: Apache-2.0
// Passes over a scene that has no shell: meshes of files, glossy and matte, on a ground, under a sky, a sun and a lamp.
// Built twice, with all of the renderer and without what paths do for shells (bench/plain.py). Prints a line of JSON.

#include "bench/bench_parts.h"
#include "bench/bench_view.h"
#include "stfLib/render/renderer.h"
#include "stfLib/render/shells_compiled.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

using namespace stf;

namespace {

struct Arguments {
    std::vector<std::string> meshes;
    int size = 256, passes = 12;
};

ControlMesh ground(const Box3f& box) {
    const float reach = 5 * box.diagonal(), y = box.lo.y;
    const Vec3f middle = (box.lo + box.hi) * 0.5f;
    ControlMesh mesh;
    mesh.scheme = ControlMesh::Scheme::None;
    for (const auto& [x, z] : {std::pair(-1, 1), std::pair(1, 1), std::pair(1, -1), std::pair(-1, -1)}) {
        mesh.points.push_back(Vec3f(middle.x + float(x) * reach, y, middle.z + float(z) * reach));
    }
    mesh.faceVertexCounts = {4};
    mesh.faceVertexIndices = {0, 1, 2, 3};
    return mesh;
}

PreviewSurface surfaceOf(const Rgb& color, float ior, float roughness) {
    PreviewSurface s;
    s.diffuseColor = color;
    s.ior = ior;
    s.roughness = roughness;
    return s;
}

void addLights(Scene& scene, const Box3f& box) {
    Light sky;
    sky.type = Light::Type::Dome;
    sky.emission = Rgb(0.4f, 0.5f, 0.6f);
    scene.setLight("/sky", sky);
    scene.setLight("/sun", sunFrom(Vec3d(0.5, 0.7, 1), Rgb(2.0f)));
    Light lamp;
    lamp.type = Light::Type::Sphere;
    lamp.radius = 0.1f * box.diagonal();
    lamp.lightToWorld.translation = Vec3d(box.hi) + Vec3d(box.hi - box.lo);
    lamp.emission = Rgb(20.0f, 14.0f, 8.0f);
    scene.setLight("/lamp", lamp);
}

/// From a little above, at the box on its ground.
Camera lookAt(const Box3f& box) {
    const Vec3d target = (Vec3d(box.lo) + Vec3d(box.hi)) * 0.5, z = normalize(Vec3d(0.3, 0.5, 1)),
                x = normalize(cross(Vec3d(0, 1, 0), z)), y = cross(z, x);
    const double reach = box.diagonal(), opening = 0.3, low = 0.1 * reach, high = 100 * reach;
    const Vec3d eye = target + z * (2 * reach);
    const Matrix4 view{x.x, y.x, z.x, 0, x.y,          y.y,          z.y,          0,
                       x.z, y.z, z.z, 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1};
    return Camera(view, squareFrustum(opening, low, high));
}

nlohmann::ordered_json run(const Arguments& a) {
    Scene scene;
    scene.setMaterial("/matte", surfaceOf(Rgb(0.7f, 0.6f, 0.5f), 1.0f, 1.0f));
    scene.setMaterial("/glossy", surfaceOf(Rgb(0.2f, 0.4f, 0.3f), 1.5f, 0.3f));
    Box3f box;
    for (std::size_t i = 0; i < a.meshes.size(); ++i) {
        const std::string id = "/mesh" + std::to_string(i);
        const ControlMesh mesh = meshOf(a.meshes[i]);
        for (const Vec3f& p : mesh.points) {
            box.add(p);
        }
        scene.setMesh(id, mesh, 0);
        scene.setInstances(id, {MeshInstance()});
        scene.setMeshMaterial(id, i % 2 ? "/matte" : "/glossy");
    }
    scene.setMesh("/ground", ground(box), 0);
    scene.setInstances("/ground", {MeshInstance()});
    scene.setMeshMaterial("/ground", "/matte");
    addLights(scene, box);

    Renderer renderer;
    RenderSettings settings;
    settings.threads = 1;
    settings.samples = 1 << 20;
    renderer.setSettings(settings);
    renderer.setCamera(lookAt(box), a.size, a.size);
    Progress progress;
    renderer.prepare(scene, progress);
    renderer.renderPass(progress); // with AOVs, which further passes are without
    const std::uint64_t before = renderer.stats().rays;
    double seconds = 1e300;
    for (int i = 0; i < a.passes; ++i) {
        seconds = std::min(seconds, processorSeconds([&] {
                               renderer.renderPass(progress);
                               return 0.0f;
                           }));
    }
    double sum = 0;
    for (const float value : renderer.film().read(Aov::Color)) {
        sum += value;
    }
    return {{"shells", kShellsCompiled},
            {"seconds", seconds},
            {"rays", (renderer.stats().rays - before) / std::uint64_t(a.passes)},
            {"sum", sum}};
}

} // namespace

int main(int argc, char** argv) {
    Arguments a;
    CLI::App app("A pass over a scene without shells", "stf_bench_plain");
    app.add_option("mesh", a.meshes, "OBJ, PLY, STL or OFF")->required();
    app.add_option("--size", a.size, "Of the picture, pixels")->check(CLI::Range(16, 4096));
    app.add_option("--passes", a.passes, "The quickest counts")->check(CLI::Range(1, 1000));
    CLI11_PARSE(app, argc, argv);
    try {
        std::puts(run(a).dump().c_str());
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stf_bench_plain: %s\n", e.what());
        return 2;
    }
}
