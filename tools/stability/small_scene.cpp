// SPDX-License-Identifier: Apache-2.0
#include "tools/stability/small_scene.h"

#include "stfLib/transport/precompute.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"

#include <cmath>
#include <filesystem>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;

// Computed once per process: cases share volumes.
std::shared_ptr<const StfTable> sharedTable(const std::shared_ptr<const BaseVolume>& volume,
                                            const TransportOptions& options, Progress& progress,
                                            const MessageSink& messages) {
    static std::map<std::string, std::shared_ptr<const StfTable>> known;
    std::shared_ptr<const StfTable>& table = known[volume->contentHash() + options.key()];
    if (!table) {
        table = std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
    }
    return table;
}

template<class Each>
void eachColour(const SmallPicture& p, Each&& each) {
    for (std::size_t i = 0; i < p.color.size(); ++i) {
        if (i % 4 != 3) {
            each(p.color[i], i);
        }
    }
}

} // namespace

bool SmallPicture::finite() const {
    bool all = !color.empty();
    for (float c : color) {
        all = all && std::isfinite(c) && c >= 0;
    }
    return all;
}

float SmallPicture::largest() const {
    float most = 0;
    eachColour(*this, [&](float c, std::size_t) { most = std::max(most, c); });
    return most;
}

Vec3d SmallPicture::mean() const {
    Vec3d sum(0.0);
    eachColour(*this, [&](float c, std::size_t i) { sum[int(i % 4)] += double(c); });
    return sum / (double(color.size()) / 4);
}

double SmallPicture::error() const {
    const double m = mean().y, n = double(color.size()) / 4;
    double squares = 0;
    for (std::size_t i = 1; i < color.size(); i += 4) {
        squares += (double(color[i]) - m) * (double(color[i]) - m);
    }
    return std::sqrt(squares / n / (n - 1));
}

bool SmallPicture::said(const std::string& part) const {
    return std::any_of(messages.begin(), messages.end(),
                       [&](const std::string& m) { return m.find(part) != std::string::npos; });
}

PlanEntry SmallPicture::entry(const std::string& stage) const {
    const auto it = std::find_if(plan.begin(), plan.end(), [&](const PlanEntry& e) { return e.stage == stage; });
    return it == plan.end() ? PlanEntry() : *it;
}

double largestDifference(const SmallPicture& a, const SmallPicture& b) {
    double most = 0;
    eachColour(a, [&](float c, std::size_t i) { most = std::max(most, std::abs(double(c) - double(b.color[i]))); });
    const double scale = double(b.largest());
    return scale > 0 ? most / scale : most;
}

double rmsDifference(const SmallPicture& a, const SmallPicture& b) {
    double difference = 0, all = 0;
    eachColour(a, [&](float c, std::size_t i) {
        difference += std::pow(double(c) - double(b.color[i]), 2);
        all += std::pow(double(b.color[i]), 2);
    });
    return all > 0 ? std::sqrt(difference / all) : std::sqrt(difference);
}

ControlMesh squareMesh() {
    ControlMesh m;
    m.scheme = ControlMesh::Scheme::None;
    m.points = {{-10, -10, 0}, {10, -10, 0}, {10, 10, 0}, {-10, 10, 0}};
    m.faceVertexCounts = {4};
    m.faceVertexIndices = {0, 1, 2, 3};
    m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    m.uvIndices = {0, 1, 2, 3};
    return m;
}

ControlMesh cubeMesh(float edge, ControlMesh::Scheme scheme) {
    ControlMesh m;
    m.scheme = scheme;
    for (int i = 0; i < 8; ++i) {
        m.points.push_back(Vec3f(i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f) * edge);
    }
    m.faceVertexCounts.assign(6, 4);
    m.faceVertexIndices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    return m;
}

BaseVolume uniformVolume(double tau, double albedo, double g, int layers, double depthMm) {
    SampleOptions o;
    o.size = {1, 1, layers};
    o.voxelMm = depthMm / layers;
    o.extinction = Rgb(float(tau / depthMm));
    o.albedo = Rgb(float(albedo));
    o.g = float(g);
    BaseVolume v = makeSample("uniform", o);
    v.coreSigmaA = v.coreSigmaSPrime = Vec3d(0.0);
    return v;
}

SmallScene::SmallScene(StabilityRun& stabilityRun) : volume(uniformVolume(2, 0.9, 0, 8, 2)), run(stabilityRun) {
    settings.samples = 16;
    settings.quality = 0.03f;
    settings.pixelFilter = "box";
    light().emission = Rgb(float(kPi));
}

void SmallScene::setCore(double albedo) {
    binding.coreSigmaA = Rgb(float(1 - albedo));
    binding.coreSigmaSPrime = Rgb(float(albedo));
}

void SmallScene::setLightCosine(double c) {
    const double s = std::sqrt(std::max(0.0, 1 - c * c));
    light().lightToWorld.y = {0, c, s};
    light().lightToWorld.z = {0, -s, c};
}

void SmallScene::setDome(float radiance) {
    light() = Light();
    light().type = Light::Type::Dome;
    light().emission = Rgb(radiance);
}

void SmallScene::fill(Scene& scene) const {
    scene.setMetersPerUnit(0.001 / unitsPerMm);
    const auto scaled = [&](ControlMesh m) {
        for (Vec3f& p : m.points) {
            p = Vec3f(Vec3d(p) * unitsPerMm);
        }
        return m;
    };
    scene.setMesh("/object", scaled(mesh), 0);
    scene.setInstances("/object", instances);
    scene.setVisible("/object", visible);
    if (bound) {
        StfBinding b = binding;
        b.baseVolume = volumeFile;
        if (volumeFile.empty()) {
            b.baseVolume = run.folder.file(volume.contentHash() + ".vdb");
            if (!std::filesystem::exists(b.baseVolume)) {
                writeBaseVolume(volume, b.baseVolume);
            }
        }
        scene.setStf("/object", b);
    } else {
        scene.setStf("/object", std::nullopt);
    }
    for (const auto& [id, m] : plain) {
        scene.setMesh(id, scaled(m), 0);
        scene.setInstances(id, {MeshInstance()});
    }
    for (const auto& [id, l] : lights) {
        scene.setLight(id, l);
    }
}

Camera SmallScene::camera() const {
    const Vec3d& p = lookAt;
    if (inside) {
        const double turn = upward ? -1 : 1, n = 1e-4 * unitsPerMm, f = 1e3 * unitsPerMm;
        const Matrix4 view{turn, 0, 0, 0, 0, 1, 0, 0, 0, 0, turn, 0, -p.x * turn, -p.y, -p.z * turn, 1};
        return Camera(view, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -(f + n) / (f - n), -1, 0, 0, -2 * f * n / (f - n), 0});
    }
    const double c = viewCosine, s = std::sqrt(std::max(0.0, 1 - c * c)), far = 100 * unitsPerMm;
    const double width = 2 / (viewMm * unitsPerMm);
    const Matrix4 view{1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, -p.x, -p.y * c + p.z * s, -p.y * s - p.z * c - far, 1};
    return Camera(view, {width, 0, 0, 0, 0, width, 0, 0, 0, 0, -0.5 / far, 0, 0, 0, -1, 1});
}

std::unique_ptr<Renderer> makeRenderer(int& asked, double& tableError, const TableProvider& tables) {
    return std::make_unique<Renderer>([&asked, &tableError, tables](const std::shared_ptr<const BaseVolume>& volume,
                                                                    const TransportOptions& options, Progress& progress,
                                                                    const MessageSink& messages) {
        ++asked;
        const auto table = (tables ? tables : TableProvider(sharedTable))(volume, options, progress, messages);
        tableError = table->error.total();
        return table;
    });
}

SmallPicture SmallScene::render() const {
    int asked = 0;
    double tableError = 0;
    std::vector<std::string> messages;
    const std::unique_ptr<Renderer> renderer = makeRenderer(asked, tableError, tables);
    renderer->setMessages([&](Severity, const std::string& text) { messages.push_back(text); });
    Scene scene;
    fill(scene);
    SmallPicture p = render(*renderer, scene);
    p.messages = std::move(messages);
    p.tables = asked;
    p.tableError = tableError;
    return p;
}

SmallPicture SmallScene::render(Renderer& renderer, const Scene& scene) const {
    renderer.setSettings(settings);
    renderer.setCamera(camera(), size, size);
    renderer.prepare(scene, run.progress);
    renderer.restart();
    while (!renderer.converged()) {
        if (!renderer.renderPass(run.progress)) {
            throw Cancelled();
        }
    }
    SmallPicture p;
    p.color = renderer.film().read(Aov::Color);
    p.plan = renderer.plan();
    p.stats = renderer.stats();
    return p;
}

} // namespace stf
