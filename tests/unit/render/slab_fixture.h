// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/renderer.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tests/unit/support/square_mesh.h"

#include <filesystem>
#include <functional>
#include <gtest/gtest.h>

namespace stf::test {

/// A homogeneous shell on a large flat quad (normal +z, millimetres), seen by a parallel camera. Its radiance has
/// closed forms. With `relief` it is a tile of wax with all colours alike, 2.5 mm wide.
struct Slab {
    enum class Lit { Distant, Dome, Dark };

    double tau = 2, albedo = 0.9, g = 0; ///< of the shell
    double extinction = 1;               ///< of the shell, 1/mm
    double ior = 1;
    double emission = 0; ///< radiance per mm
    /// Of the core, kappa 1/mm and isotropic; 0: black.
    double coreAlbedo = 0;
    double viewCosine = 1;
    Lit lit = Lit::Distant; ///< irradiance 1 from afar, a dome of radiance 1, or nothing
    double lightCosine = 1;
    int layersPerMm = 10;
    double ceilingMm = 0; ///< how high above it hangs another such slab that faces it; 0: there is none
    /// The slab below, which is seen, is a plain matte surface of this colour, and only the ceiling a shell; 0: not.
    double plainColor = 0;
    bool relief = false;
    std::function<void(BaseVolume&)> shape; ///< changes the volume; empty: nothing
    double viewMm = 0.4;                    ///< width of what the camera sees
    float quality = 0.01f;
    std::string transport; ///< empty: the renderer's default
    RenderSettings settings;
    TableProvider tables = sharedTables;
    PathTracerProvider reference; ///< of the setting `integrator`
    std::function<void(Scene&)> more; ///< into the scene; empty: nothing
    std::vector<std::string> messages;
    std::vector<PlanEntry> plan;

    static constexpr int kWidth = 8;

    BaseVolume volume() const {
        SampleOptions o;
        o.voxelMm = 1.0 / layersPerMm;
        o.size = {1, 1, std::max(1, int(std::lround(tau / extinction * layersPerMm)))};
        o.extinction = Rgb(float(extinction));
        o.albedo = Rgb(float(albedo));
        o.g = float(g);
        if (relief) {
            o = {};
            o.size = {16, 16, 12};
        }
        BaseVolume v = makeSample(relief ? "wax" : "uniform", o);
        if (relief) {
            for (Rgb& k : v.extinction) {
                k = Rgb(k.x);
            }
            v.albedo.assign(v.voxelCount(), Rgb(float(albedo)));
            v.g.assign(v.voxelCount(), float(g));
        }
        if (ior != 1) {
            v.ior.assign(v.voxelCount(), float(ior));
        }
        if (emission > 0) {
            v.emission.assign(v.voxelCount(), Rgb(float(emission)));
        }
        if (shape) {
            shape(v);
        }
        return v;
    }

    std::string volumePath() const {
        const auto folder = std::filesystem::temp_directory_path() / "stf_render_tests";
        std::filesystem::create_directories(folder);
        const BaseVolume v = volume();
        const std::string path = (folder / (v.contentHash() + ".vdb")).string();
        writeBaseVolume(v, path);
        return path;
    }

    /// What the renderer asks its tables by.
    TransportOptions transportOptions() const {
        TransportOptions o;
        o.quality = quality;
        o.form = parseTransportForm(transport.empty() ? settings.transport : transport);
        return o;
    }

    /// Pixels of the image, row by row; RGBA for the colour.
    std::vector<float> render(Aov aov = Aov::Color) {
        const std::unique_ptr<Renderer> renderer = prepare();
        return take(*renderer, viewCosine, aov);
    }

    /// A mean, its standard error by the image's noise, and the error that the table says it has, as a share of it.
    struct Measured {
        double mean = 0, error = 0, table = 0;

        /// Within 4 standard errors, the table's own error and a known relative error of method; not too noisy to tell.
        testing::AssertionResult near(double exact, double relative) const {
            const double allowed = 4 * error + (table + relative) * std::abs(exact);
            const auto text = [&](testing::AssertionResult r) {
                return r << mean << " +- " << error << " is off by " << 100 * (mean / exact - 1) << " % from " << exact
                         << ", table error " << 100 * table << " %";
            };
            std::printf("%.6f, exact %.6f: %+.2f %%, standard error %.2f %%, table %.2f %%\n", mean, exact,
                        100 * (mean / exact - 1), 100 * error / exact, 100 * table);
            if (!(error <= 0.02 * std::abs(exact))) {
                return text(testing::AssertionFailure() << "too noisy to tell: ");
            }
            return std::abs(mean - exact) <= allowed ? testing::AssertionSuccess() : text(testing::AssertionFailure());
        }
    };

    /// Radiance along the view.
    Measured radiance() {
        const std::unique_ptr<Renderer> renderer = prepare();
        return radianceAt(*renderer, viewCosine);
    }

    /// Share of the incident flux that leaves through the top into all directions, without the mirror image of a
    /// distant light: INT L cos dw over the flux of the light, by Gauss-Legendre nodes in the polar angle: six, or six
    /// more up to `peak` radians from the normal, where a phase function has a narrow peak.
    Measured reflectance(double peak = 0) {
        constexpr double kNode[3] = {0.2386191860831969, 0.6612093864662645, 0.9324695142031521};
        constexpr double kWeight[3] = {0.4679139345726910, 0.3607615730481386, 0.1713244923791704};
        constexpr double kPi = 3.14159265358979323846;
        const double flux = lit == Lit::Dome ? kPi : lightCosine;
        const std::unique_ptr<Renderer> renderer = prepare();
        Measured sum;
        double squares = 0;
        const auto panel = [&](double from, double to) {
            for (int i = 0; i < 6; ++i) {
                const double half = 0.5 * (to - from), angle = from + half * (1 + (i % 2 ? 1 : -1) * kNode[i / 2]);
                const Measured r = radianceAt(*renderer, std::cos(angle));
                const double scale = half * kWeight[i / 2] * 2 * kPi * std::sin(angle) * std::cos(angle) / flux;
                sum.mean += r.mean * scale;
                squares += r.error * r.error * scale * scale;
                sum.table = r.table;
            }
        };
        if (peak > 0) {
            panel(0, peak);
        }
        panel(peak, 0.5 * kPi);
        sum.error = std::sqrt(squares);
        return sum;
    }

    /// Computes each table once per process.
    static std::shared_ptr<const StfTable> sharedTables(const std::shared_ptr<const BaseVolume>& volume,
                                                        const TransportOptions& options, Progress& progress,
                                                        const MessageSink& sink) {
        static std::map<std::string, std::shared_ptr<const StfTable>> known;
        std::shared_ptr<const StfTable>& table = known[volume->contentHash() + options.key()];
        if (!table) {
            table = std::make_shared<const StfTable>(precompute(*volume, options, progress, sink));
        }
        return table;
    }

private:
    double tableError_ = 0;

    std::unique_ptr<Renderer> prepare() {
        Scene scene;
        scene.setMetersPerUnit(0.001);
        scene.setMesh("/slab", squareMesh({0, 0, 0}, {40, 0, 0}, {0, 40, 0}), 0);
        StfBinding binding;
        binding.baseVolume = volumePath();
        binding.quality = quality;
        binding.transport = transport;
        binding.coreSigmaA = Rgb(float(1 - coreAlbedo));
        binding.coreSigmaSPrime = Rgb(float(coreAlbedo));
        binding.coreModel = coreAlbedo > 0 ? "dipole" : "none";
        if (plainColor > 0) {
            auto plain = squareMesh({0, 0, 0}, {40, 0, 0}, {0, 40, 0});
            plain.colors = {Rgb(float(plainColor))};
            scene.setMesh("/slab", plain, 0);
        } else {
            scene.setStf("/slab", binding);
        }
        scene.setInstances("/slab", {MeshInstance()});
        if (ceilingMm > 0) {
            scene.setMesh("/ceiling", squareMesh({0, 0, float(ceilingMm)}, {40, 0, 0}, {0, -40, 0}), 0);
            scene.setStf("/ceiling", binding);
            scene.setInstances("/ceiling", {MeshInstance()});
        }
        if (lit != Lit::Dark) {
            Light light;
            light.emission = Rgb(1.0f);
            light.type = lit == Lit::Dome ? Light::Type::Dome : Light::Type::Distant;
            if (lit == Lit::Distant) {
                light.lightToWorld = rotationAboutX(std::acos(lightCosine));
            }
            scene.setLight("/light", light);
        }

        if (more) {
            more(scene);
        }

        tableError_ = 0;
        auto renderer = std::make_unique<Renderer>(
            [this](const std::shared_ptr<const BaseVolume>& asked, const TransportOptions& options, Progress& progress,
                   const MessageSink& sink) {
                const std::shared_ptr<const StfTable> table = tables(asked, options, progress, sink);
                tableError_ = table->error.total();
                return table;
            },
            MapProvider(), reference);
        renderer->setMessages([this](Severity, const std::string& text) { messages.push_back(text); });
        renderer->setSettings(settings);
        Progress progress;
        renderer->prepare(scene, progress);
        plan = renderer->plan();
        return renderer;
    }

    std::vector<float> take(Renderer& renderer, double cosine, Aov aov) const {
        renderer.setCamera(camera(cosine), kWidth, kWidth);
        renderer.restart();
        Progress progress;
        while (!renderer.converged()) {
            renderer.renderPass(progress);
        }
        return renderer.film().read(aov);
    }

    Measured radianceAt(Renderer& renderer, double cosine) const {
        const std::vector<float> p = take(renderer, cosine, Aov::Color);
        double sum = 0, squares = 0;
        const int n = kWidth * kWidth;
        for (int i = 0; i < n; ++i) {
            const double v = double(p[std::size_t(i) * 4 + 1]);
            sum += v;
            squares += v * v;
        }
        const double mean = sum / n;
        return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1)), tableError_};
    }

    static Transform rotationAboutX(double angle) {
        Transform t;
        t.y = {0, std::cos(angle), std::sin(angle)};
        t.z = {0, -std::sin(angle), std::cos(angle)};
        return t;
    }

    // Looks at the origin from 100 mm away, tilted about x to the other side than the light; sees little, so that
    // grazing views stay on the quad.
    Camera camera(double c) const {
        const double s = std::sqrt(std::max(0.0, 1 - c * c));
        const Matrix4 worldToView{1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, -100, 1};
        const Matrix4 projection{2 / viewMm, 0, 0, 0, 0, 2 / viewMm, 0, 0, 0, 0, -0.005, 0, 0, 0, -1, 1};
        return Camera(worldToView, projection);
    }
};

} // namespace stf::test
