// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"

#include <filesystem>
#include <gtest/gtest.h>

namespace stf::test {

/// A homogeneous shell on a large flat quad (normal +z, millimetres), seen by a parallel camera. Its radiance has
/// closed forms.
struct Slab {
    double tau = 2, albedo = 0.9; ///< of the shell; kappa is 1/mm
    double coreAlbedo = 0;        ///< of the core, kappa 1/mm; 0: black
    double viewCosine = 1;
    bool dome = false; ///< radiance 1; else a distant light of irradiance 1
    double lightCosine = 1;
    int layersPerMm = 10;
    RenderSettings settings;
    TableProvider tables;
    std::vector<std::string> messages;
    std::vector<PlanEntry> plan;

    static constexpr int kWidth = 8;

    std::string volumePath() const {
        const auto folder = std::filesystem::temp_directory_path() / "stf_render_tests";
        std::filesystem::create_directories(folder);
        SampleOptions o;
        o.voxelMm = 1.0 / layersPerMm;
        o.size = {1, 1, std::max(1, int(std::lround(tau * layersPerMm)))};
        o.extinction = Rgb(1.0f);
        o.albedo = Rgb(float(albedo));
        const BaseVolume v = makeSample("uniform", o);
        const std::string path = (folder / (v.contentHash() + ".vdb")).string();
        writeBaseVolume(v, path);
        return path;
    }

    /// Pixels of the image, row by row, RGBA.
    std::vector<float> render(Aov aov = Aov::Color) {
        Scene scene;
        scene.setMetersPerUnit(0.001);
        ControlMesh quad;
        quad.scheme = ControlMesh::Scheme::None;
        quad.points = {{-40, -40, 0}, {40, -40, 0}, {40, 40, 0}, {-40, 40, 0}};
        quad.faceVertexCounts = {4};
        quad.faceVertexIndices = {0, 1, 2, 3};
        quad.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        quad.uvIndices = {0, 1, 2, 3};
        scene.setMesh("/slab", quad, 0);
        StfBinding binding;
        binding.baseVolume = volumePath();
        binding.quality = 0.006f;
        binding.coreSigmaA = Rgb(float(1 - coreAlbedo));
        binding.coreSigmaSPrime = Rgb(float(coreAlbedo));
        binding.coreModel = coreAlbedo > 0 ? "dipole" : "none";
        scene.setStf("/slab", binding);
        scene.setInstances("/slab", {MeshInstance()});
        Light light;
        light.emission = Rgb(1.0f);
        if (dome) {
            light.type = Light::Type::Dome;
        } else {
            light.type = Light::Type::Distant;
            light.lightToWorld = rotationAboutX(std::acos(lightCosine));
        }
        scene.setLight("/light", light);

        Renderer renderer(tables);
        renderer.setMessages([this](Severity, const std::string& text) { messages.push_back(text); });
        renderer.setSettings(settings);
        renderer.setCamera(camera(), kWidth, kWidth);
        Progress progress;
        renderer.prepare(scene, progress);
        renderer.restart();
        while (!renderer.converged()) {
            renderer.renderPass(progress);
        }
        plan = renderer.plan();
        return renderer.film().read(aov);
    }

    /// Mean radiance of the image and its standard error, from the pixels.
    struct Radiance {
        double mean, error;
    };
    Radiance radiance() {
        const std::vector<float> p = render();
        double sum = 0, squares = 0;
        const int n = kWidth * kWidth;
        for (int i = 0; i < n; ++i) {
            const double v = double(p[std::size_t(i) * 4 + 1]);
            sum += v;
            squares += v * v;
        }
        const double mean = sum / n;
        std::printf("radiance %.6f\n", mean);
        return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
    }

private:
    static Transform rotationAboutX(double angle) {
        Transform t;
        t.y = {0, std::cos(angle), std::sin(angle)};
        t.z = {0, -std::sin(angle), std::cos(angle)};
        return t;
    }

    // Looks at the origin from 100 mm away, tilted about x to the other side than the light; sees 2 mm.
    Camera camera() const {
        const double c = viewCosine, s = std::sqrt(std::max(0.0, 1 - c * c));
        const Matrix4 worldToView{1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, -100, 1};
        const Matrix4 projection{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -0.005, 0, 0, 0, -1, 1};
        return Camera(worldToView, projection);
    }
};

} // namespace stf::test
