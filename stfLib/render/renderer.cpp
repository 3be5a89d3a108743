// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/renderer.h"

#include "stfLib/base/parallel.h"
#include "stfLib/render/adaptive_sampling.h"
#include "stfLib/render/core_light.h"
#include "stfLib/render/integrator.h"
#include "stfLib/render/shell_builder.h"
#include "stfLib/transport/precompute.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <set>

namespace stf {

namespace {

using Clock = std::chrono::steady_clock;
constexpr int kTile = 16; // pixels

double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::shared_ptr<const StfTable> computeTable(const std::shared_ptr<const BaseVolume>& volume,
                                             const TransportOptions& options, Progress& progress,
                                             const MessageSink& messages) {
    return std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
}

// Inverse of the tent's distribution function: samples spread over two pixels, each counts the same.
float tent(float u) {
    return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 - 2 * u);
}

} // namespace

struct Renderer::Impl {
    Impl(TableProvider tables, MapProvider maps)
        : builder(tables ? std::move(tables) : TableProvider(computeTable), std::move(maps),
                  [this](Severity s, const std::string& text) { say(s, text); }) {}

    // Each text once: a host prepares again after every edit.
    void say(Severity severity, const std::string& text) {
        const std::lock_guard<std::mutex> lock(messageMutex);
        if (said.insert(text).second) {
            report(sink, severity, text);
        }
    }

    struct Kept {
        std::uint64_t meshVersion = 0, stfVersion = 0;
        double metersPerUnit = 0;
        float quality = 0;
        std::string transport;
        std::shared_ptr<const PreparedMesh> mesh; // null where nothing can be drawn
        std::vector<PlanEntry> plan;
    };

    void prepareMesh(const std::string& id, const SceneMesh& m, double metersPerUnit, Kept& kept, Progress& progress);
    void placeInstances(const Scene& source);
    void planSurfaces();
    std::shared_ptr<const PlainMaterial> materialOf(const SceneMesh& mesh, const Scene& source);
    void restartSampling() {
        adaptive.restart(film.width(), film.height());
        passDone.assign(std::size_t(film.width()) * std::size_t(film.height()), 0);
    }

    std::mutex messageMutex;
    MessageSink sink;
    std::set<std::string> said;

    RenderSettings settings;
    Camera camera;
    Film film;
    ShellBuilder builder;
    ShellCores cores;
    std::map<std::string, Kept> kept;
    TextureStore textures;
    std::map<std::string, std::shared_ptr<const PlainMaterial>> materials; // of what is drawn
    std::unique_ptr<PreparedScene> scene;
    Rgb clearColor{0.0f};
    float clearAlpha = 0;
    std::uint64_t preparedVersion = 0, lightVersion = 0;
    RenderSettings preparedSettings; ///< tables depend on quality and form, the core's samples on the seed
    int passes = 0;
    AdaptiveSampling adaptive;
    std::vector<std::uint32_t> passDone; ///< per pixel, passes that it took part in or was spared
    RenderStats stats;
    std::vector<PlanEntry> scenePlan;
    Clock::time_point prepareStart;
};

void Renderer::Impl::prepareMesh(const std::string& id, const SceneMesh& m, double metersPerUnit, Kept& k,
                                 Progress& progress) {
    k.meshVersion = m.meshVersion;
    k.stfVersion = m.stfVersion;
    k.metersPerUnit = metersPerUnit;
    k.quality = settings.quality;
    k.transport = settings.transport;
    k.mesh = nullptr;
    k.plan.clear();
    ControlMesh mesh = *m.mesh;
    auto prepared = std::make_shared<PreparedMesh>();
    try {
        const MeshRepairs repairs = sanitize(mesh);
        if (const std::string summary = repairs.summary(); !summary.empty()) {
            say(Severity::Warning, id + ": " + summary);
        }
    } catch (const Error& e) {
        say(Severity::Error, id + ": mesh " + e.what());
        return;
    }
    if (m.stf) {
        try {
            auto shell =
                builder.build(id, mesh, m.refineLevel, *m.stf, metersPerUnit, settings, progress, stats, k.plan);
            prepared->surface = shell->surface;
            prepared->rayMesh = shell->rayMesh;
            prepared->shell = shell;
            k.mesh = prepared;
            return;
        } catch (const Cancelled&) {
            k.meshVersion = 0; // again next time
            throw;
        } catch (const std::exception& e) {
            say(Severity::Error, id + ": " + e.what() + "; drawn with its displayColor");
            k.plan.push_back({id, "shell", false, e.what(), 0});
        }
    }
    try {
        RefineOptions options;
        options.level = m.refineLevel;
        if (mesh.scheme != ControlMesh::Scheme::None) {
            Box3f box;
            for (const Vec3f& p : mesh.points) {
                box.add(p);
            }
            options.targetEdge = box.diagonal() / 100;
        }
        auto surface = std::make_shared<const RefinedSurface>(
            refine(mesh, options, [&](Severity s, const std::string& text) { say(s, id + ": " + text); }));
        prepared->rayMesh = std::make_shared<const RayMesh>(surface->points, surface->triangles);
        prepared->surface = surface;
        k.mesh = prepared;
    } catch (const Error& e) {
        say(Severity::Error, id + ": mesh " + e.what());
    }
}

// Only what a plain surface shows is looked up, and only what changed is made anew.
std::shared_ptr<const PlainMaterial> Renderer::Impl::materialOf(const SceneMesh& m, const Scene& source) {
    const auto it = source.materials().find(m.material);
    if (it == source.materials().end()) {
        return nullptr;
    }
    std::shared_ptr<const PlainMaterial>& made = materials[m.material];
    if (!made || !(made->surface() == it->second)) {
        made = std::make_shared<const PlainMaterial>(m.material, it->second, textures,
                                                     [this](Severity s, const std::string& text) { say(s, text); });
    }
    return made;
}

// Which surfaces there are beside shells, and what of their light is followed.
void Renderer::Impl::planSurfaces() {
    scenePlan.erase(std::remove_if(scenePlan.begin(), scenePlan.end(),
                                   [](const PlanEntry& e) { return e.stage == "materials" || e.stage == "bounces"; }),
                    scenePlan.end());
    int plain = 0, read = 0, clear = 0;
    std::set<const PlainMaterial*> used;
    scene->surfacesBounce = false;
    for (const PreparedInstance& i : scene->instances) {
        if (i.mesh->shell) {
            continue;
        }
        ++plain;
        scene->surfacesBounce = true;
        if (i.material && used.insert(i.material.get()).second) {
            ++read;
            clear += i.material->opaque() ? 0 : 1;
        }
    }
    scene->clearSurfaces = clear > 0;
    int images = 0;
    for (const PlainMaterial* m : used) {
        images += m->textures();
    }
    scenePlan.push_back({"scene", "materials", read > 0,
                         read ? std::to_string(read) + " read for surfaces without a shell, inputs with a texture: " +
                                    std::to_string(images) + ", not opaque: " + std::to_string(clear)
                         : plain ? "plain surfaces show their displayColor"
                                 : "no surface without a shell",
                         0});
    const bool bounces = scene->surfacesBounce && settings.maxDepth > 0;
    scenePlan.push_back({"scene", "bounces", bounces,
                         bounces ? "up to " + std::to_string(settings.maxDepth) + " off surfaces without a shell"
                         : plain ? "stf:maxDepth is 0"
                                 : "no surface without a shell",
                         0});
}

void Renderer::Impl::placeInstances(const Scene& source) {
    std::vector<RayInstance> rays;
    scene->instances.clear();
    std::set<std::string> bound;
    for (const auto& [id, m] : source.meshes()) {
        if (m.visible) {
            bound.insert(m.material);
        }
    }
    for (auto it = materials.begin(); it != materials.end();) {
        it = bound.count(it->first) && source.materials().count(it->first) ? std::next(it) : materials.erase(it);
    }
    // The middle of the scene, in double precision.
    Vec3d low(1e300), high(-1e300);
    for (const auto& [id, m] : source.meshes()) {
        const auto it = kept.find(id);
        if (!m.visible || it == kept.end() || !it->second.mesh) {
            continue;
        }
        const Box3f& box = it->second.mesh->surface->bounds;
        for (const MeshInstance& i : m.instances) {
            const Vec3d p = i.objectToWorld.point((Vec3d(box.lo) + Vec3d(box.hi)) * 0.5);
            for (int a = 0; a < 3 && isFinite(p); ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
        }
    }
    scene->origin = low.x <= high.x ? (low + high) * 0.5 : Vec3d(0.0);
    for (const auto& [id, m] : source.meshes()) {
        const auto it = kept.find(id);
        if (!m.visible || it == kept.end() || !it->second.mesh) {
            continue;
        }
        for (const MeshInstance& i : m.instances) {
            if (!i.objectToWorld.invertible()) {
                say(Severity::Error, id + ": its transform is singular or not finite, it is left out");
                continue;
            }
            PreparedInstance p;
            p.mesh = it->second.mesh;
            p.material = p.mesh->shell ? nullptr : materialOf(m, source);
            if (p.material && p.material->usesUvs() && p.mesh->surface->uvTriangles.empty()) {
                say(Severity::Warning, id + ": material " + m.material +
                                           " has textures, but the mesh has no texture coordinates; (0, 0) is read");
            }
            p.objectToWorld = i.objectToWorld;
            p.objectToWorld.translation -= scene->origin;
            p.worldToObject = p.objectToWorld.inverse();
            p.primId = m.primId;
            p.instanceId = i.instanceId;
            RayInstance r;
            r.mesh = p.mesh->rayMesh;
            r.objectToWorld = p.objectToWorld;
            r.id = std::uint32_t(scene->instances.size());
            rays.push_back(r);
            scene->instances.push_back(std::move(p));
        }
    }
    scene->rays = std::make_unique<const RayScene>(rays);
    const Box3f box = scene->rays->bounds();
    const float farthest = box.empty() ? 1.0f
                                       : std::max(std::max(std::abs(box.lo.x), std::abs(box.hi.x)),
                                                  std::max(std::max(std::abs(box.lo.y), std::abs(box.hi.y)),
                                                           std::max(std::abs(box.lo.z), std::abs(box.hi.z))));
    scene->rounding = 5e-7f * farthest;
    scene->shadowOffset = 1e-5f * box.diagonal() + scene->rounding;
}

Renderer::Renderer(TableProvider tables, MapProvider maps)
    : impl_(std::make_unique<Impl>(std::move(tables), std::move(maps))) {}
Renderer::~Renderer() = default;

void Renderer::setMessages(MessageSink messages) {
    const std::lock_guard<std::mutex> lock(impl_->messageMutex);
    impl_->sink = std::move(messages);
}

void Renderer::setSettings(const RenderSettings& settings) {
    impl_->settings = settings;
}

void Renderer::setCamera(const Camera& camera, int width, int height) {
    impl_->camera = camera;
    if (impl_->film.width() != width || impl_->film.height() != height) {
        impl_->film.resize(width, height);
        impl_->restartSampling();
    }
}

void Renderer::setClearColor(const Rgb& color, float alpha) {
    impl_->clearColor = color;
    impl_->clearAlpha = alpha;
}

void Renderer::prepare(const Scene& source, Progress& progress) {
    Impl& s = *impl_;
    setThreadCount(s.settings.threads);
    s.prepareStart = Clock::now();
    // Whether surfaces give light back at all, cores have to know.
    const bool coresStay =
        !s.scene || !s.scene->surfacesBounce || (s.settings.maxDepth > 0) == (s.preparedSettings.maxDepth > 0);
    if (s.scene && coresStay && source.version() == s.preparedVersion &&
        s.settings.quality == s.preparedSettings.quality && s.settings.transport == s.preparedSettings.transport &&
        s.settings.seed == s.preparedSettings.seed) {
        if (s.settings.maxDepth != s.preparedSettings.maxDepth) {
            s.preparedSettings.maxDepth = s.settings.maxDepth;
            s.planSurfaces(); // all that it changes of what is prepared
        }
        return;
    }
    if (!s.scene) {
        s.scene = std::make_unique<PreparedScene>();
    }
    s.preparedVersion = 0;
    s.scenePlan.clear();
    // They would keep what is about to be replaced in memory beside its replacement.
    s.scene->instances.clear();
    s.scene->rays.reset();

    for (auto it = s.kept.begin(); it != s.kept.end();) {
        it = source.meshes().count(it->first) ? std::next(it) : s.kept.erase(it);
    }
    for (const auto& [id, m] : source.meshes()) {
        Impl::Kept& k = s.kept[id];
        const bool needed = m.visible && m.mesh && !m.instances.empty();
        const bool current = k.meshVersion == m.meshVersion && k.stfVersion == m.stfVersion &&
                             k.metersPerUnit == source.metersPerUnit() && k.quality == s.settings.quality &&
                             k.transport == s.settings.transport;
        if (needed && !current) {
            s.prepareMesh(id, m, source.metersPerUnit(), k, progress);
        } else if (!needed) {
            k.plan = {{id, "mesh", false, m.visible ? "nothing to draw" : "invisible", 0}};
            k.meshVersion = 0;
        }
    }
    if (s.lightVersion != source.lightVersion()) {
        s.scene->lights = LightSet(source.lights(), [&](Severity v, const std::string& text) { s.say(v, text); });
        s.lightVersion = source.lightVersion();
    }
    s.scenePlan.push_back(
        {"scene", "lights", s.scene->lights.count() > 0,
         std::to_string(s.scene->lights.count()) + " of " + std::to_string(source.lights().size()) + " give light", 0});
    s.placeInstances(source);
    s.planSurfaces();
    s.scene->lights.place(s.scene->origin);
    s.builder.dropUnused();
    const auto emits = [](const PreparedInstance& i) { return i.mesh->shell && i.mesh->shell->medium->emits(); };
    const std::vector<PreparedInstance>& instances = s.scene->instances;
    const auto shines = [&](const PreparedInstance& i) { return emits(i) || (i.material && i.material->emits()); };
    if (s.scene->lights.count() == 0 && std::none_of(instances.begin(), instances.end(), shines)) {
        s.say(Severity::Warning, "the scene has no light that hdStf knows: what is drawn is black");
    }

    // The core depends on lights and on whatever throws shadows: any edit of those solves it again, the camera does
    // not.
    const auto coreStart = Clock::now();
    const bool bounces = s.scene->surfacesBounce && s.settings.maxDepth > 0;
    int solved = 0;
    std::string summary;
    for (PreparedInstance& i : s.scene->instances) {
        const ShellObject* shell = i.mesh->shell.get();
        if (shell && !shell->coreBlack && (s.scene->lights.count() > 0 || emits(i) || bounces)) {
            ++solved;
            const std::shared_ptr<const ShellCore> core = s.cores.prepare(*shell, s.settings.seed, progress);
            i.core = shell->grid->spreadCoreRadiance(
                coreRadiance(*core, *shell, i.objectToWorld, *s.scene, bounces, s.settings.seed, progress));
            summary = summary.empty() ? core->summary : summary;
        }
    }
    s.cores.dropUnused();
    s.stats.coreSeconds += since(coreStart);
    s.scenePlan.push_back(
        {"scene", "core", solved > 0,
         solved ? "solved for lights and geometry, instances: " + std::to_string(solved) + ", the first: " + summary
                : "no lit shell with a core that scatters",
         since(coreStart)});
    // What is held now, not what was ever made: edits replace tables and grids.
    s.stats.tableBytes = s.stats.shellBytes = 0;
    std::set<const StfTable*> tables;
    std::set<const ShellGrid*> grids;
    for (const auto& [id, k] : s.kept) {
        if (const ShellObject* shell = k.mesh ? k.mesh->shell.get() : nullptr) {
            if (grids.insert(shell->grid.get()).second) {
                s.stats.shellBytes += shell->grid->memoryBytes();
            }
            if (tables.insert(shell->table.get()).second) {
                s.stats.tableBytes += shell->table->bytes();
            }
        }
    }
    s.preparedSettings = s.settings;
    s.preparedVersion = source.version();
}

void Renderer::restart() {
    impl_->film.clear();
    impl_->restartSampling();
    impl_->passes = 0;
    impl_->stats.rays = 0;
    impl_->stats.renderSeconds = 0;
    impl_->stats.firstPixelSeconds = 0;
}

bool Renderer::renderPass(Progress& progress) {
    Impl& s = *impl_;
    if (!s.scene || !s.scene->rays || converged()) {
        return true;
    }
    setThreadCount(s.settings.threads);
    s.scene->clearColor = s.clearColor;
    s.scene->clearAlpha = s.clearAlpha;
    s.scene->maxDepth = s.settings.maxDepth;
    s.scene->indirectClamp = s.settings.indirectClamp;
    const auto start = Clock::now();
    const int width = s.film.width(), height = s.film.height();
    const int tilesX = (width + kTile - 1) / kTile, tilesY = (height + kTile - 1) / kTile;
    const std::uint32_t pass = std::uint32_t(s.passes);
    s.adaptive.beforePass(s.film, pass, double(s.settings.errorTarget));
    std::atomic<std::uint64_t> rays{0};
    parallelFor(std::size_t(tilesX) * std::size_t(tilesY), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tile = begin; tile < end && !progress.cancelled(); ++tile) {
            Integrator integrator(*s.scene);
            const int x0 = int(tile) % tilesX * kTile, y0 = int(tile) / tilesX * kTile;
            for (int y = y0; y < std::min(y0 + kTile, height); ++y) {
                for (int x = x0; x < std::min(x0 + kTile, width); ++x) {
                    std::uint32_t& done = s.passDone[std::size_t(y) * std::size_t(width) + std::size_t(x)];
                    if (done > pass || !s.adaptive.active(x, y)) {
                        continue; // done before this pass was interrupted, or good enough
                    }
                    const auto ndc = [&](double px, double py) {
                        return s.camera.ray(2 * px / width - 1, 2 * py / height - 1, s.scene->origin);
                    };
                    if (pass == 0) {
                        s.film.setHit(x, y, integrator.firstHit(ndc(x + 0.5, y + 0.5), s.camera));
                    }
                    PixelSampler sampler(s.settings.seed, std::uint64_t(y) * std::uint64_t(width) + std::uint64_t(x),
                                         s.film.sampleCount(x, y));
                    const Vec2f u = sampler.next2d();
                    const Ray ray = ndc(x + 0.5 + double(tent(u.x)), y + 0.5 + double(tent(u.y)));
                    const RayCone cone =
                        s.camera.cone(2 * (x + 0.5) / width - 1, 2 * (y + 0.5) / height - 1, 2.0 / width, 2.0 / height);
                    s.film.add(x, y, integrator.sample(ray, cone, sampler));
                    done = pass + 1;
                }
            }
            rays += integrator.rays();
        }
    });
    s.stats.rays += rays;
    s.stats.renderSeconds += since(start);
    if (progress.cancelled()) {
        return false;
    }
    if (s.passes++ == 0) {
        s.stats.firstPixelSeconds = since(s.prepareStart);
    }
    return true;
}

bool Renderer::converged() const {
    return impl_->passes >= std::max(1, impl_->settings.samples) ||
           (impl_->passes > 0 && impl_->adaptive.activeCount() == 0);
}

const Film& Renderer::film() const {
    return impl_->film;
}

RenderStats Renderer::stats() const {
    RenderStats stats = impl_->stats;
    stats.samplesDone = impl_->passes;
    stats.estimatedError = impl_->film.relativeError();
    return stats;
}

std::vector<PlanEntry> Renderer::plan() const {
    std::vector<PlanEntry> all;
    for (const auto& [id, k] : impl_->kept) {
        all.insert(all.end(), k.plan.begin(), k.plan.end());
    }
    all.insert(all.end(), impl_->scenePlan.begin(), impl_->scenePlan.end());
    return all;
}

} // namespace stf
