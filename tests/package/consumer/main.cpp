// SPDX-License-Identifier: Apache-2.0
// Calls functions of an installed stfLib whose results are known. Argument: a folder to write to.
#include "stfLib/optics/fresnel.h"
#include "stfLib/optics/h_function.h"
#include "stfLib/render/preview_bsdf.h"
#include "stfLib/render/renderer.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#ifdef WITH_ACQUIRE
#include "stfLib/acquire/mesh_reader.h"

#include <fstream>
#endif

#include <cmath>
#include <cstdio>

namespace {

int failures = 0;

void expectNear(const char* what, double value, double expected, double tolerance) {
    const bool ok = std::abs(value - expected) <= tolerance;
    std::printf("%s %s: %.6f, expected %.6f\n", ok ? "ok    " : "FAILED", what, value, expected);
    failures += ok ? 0 : 1;
}

/// Mean radiance of a diffuse square of albedo 0.5 under light of the irradiance pi from its normal: 0.5.
double radianceOfSquare() {
    stf::Scene scene;
    stf::ControlMesh square;
    square.points = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    square.faceVertexCounts = {4};
    square.faceVertexIndices = {0, 1, 2, 3};
    square.scheme = stf::ControlMesh::Scheme::None;
    scene.setMesh("/square", square, 0);
    scene.setInstances("/square", {stf::MeshInstance()});
    stf::PreviewSurface look;
    look.diffuseColor = stf::Rgb(0.5f);
    look.ior = 1.0f;
    scene.setMaterial("/look", look);
    scene.setMeshMaterial("/square", "/look");
    stf::Light sun;
    sun.emission = stf::Rgb(3.14159265f);
    scene.setLight("/sun", sun);

    const double nearest = 1, farthest = 10, depth = farthest - nearest;
    const stf::Matrix4 view{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1};
    const stf::Matrix4 projection{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, -2 / depth, 0, 0, 0, -(farthest + nearest) / depth, 1};
    stf::Renderer renderer;
    stf::RenderSettings settings;
    settings.samples = 4;
    renderer.setSettings(settings);
    renderer.setCamera(stf::Camera(view, projection), 8, 8);
    stf::Progress progress;
    renderer.prepare(scene, progress);
    renderer.restart();
    while (!renderer.converged()) {
        renderer.renderPass(progress);
    }
    const std::vector<float> color = renderer.film().read(stf::Aov::Color);
    double sum = 0;
    for (std::size_t i = 0; i < color.size(); i += 4) {
        sum += color[i];
    }
    return 4 * sum / double(color.size());
}

} // namespace

int main(int argc, char** argv) try {
    const std::string folder = argc > 1 ? argv[1] : ".";
    expectNear("Fresnel reflectance of glass from its normal", stf::fresnelReflectance(1, 1.5f), 0.04, 1e-6);
    // Chandrasekhar, Radiative Transfer, table XI.
    expectNear("H(1) without absorption", stf::HFunction(0)(1), 2.9078, 1e-4);

    stf::SampleOptions options;
    options.size = {4, 4, 4};
    options.extinction = stf::Rgb(2.5f);
    const std::string path = folder + "/uniform.vdb";
    stf::writeBaseVolume(stf::makeSample("uniform", options), path);
    expectNear("extinction after writing and reading", stf::readBaseVolume(path).extinction.at(0).x, 2.5, 0);
    expectNear("radiance of a lit square", radianceOfSquare(), 0.5, 1e-5);
#ifdef WITH_ACQUIRE
    const std::string mesh = folder + "/triangle.off";
    std::ofstream(mesh) << "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    expectNear("triangles read", double(stf::readMeshFile(mesh).at(0).mesh.triangles.size()), 1, 0);
#endif
    return failures == 0 ? 0 : 1;
} catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
}
