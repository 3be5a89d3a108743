// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/renderer.h"

#include "stfLib/base/parallel.h"
#include "stfLib/render/adaptive_sampling.h"
#include "stfLib/render/cryptomatte.h"
#include "stfLib/render/denoiser.h"
#include "stfLib/render/instance_bounds.h"
#include "stfLib/render/integrator.h"
#include "stfLib/render/light_balance.h"
#include "stfLib/render/pixel_filter.h"
#include "stfLib/render/shell_builder.h"
#include "stfLib/surface/split_parts.h"
#include "stfLib/transport/precompute.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <set>
#include <sstream>

namespace stf {

namespace {

using Clock = std::chrono::steady_clock;
constexpr int kTile = 16;                              // pixels
constexpr std::size_t kMostEmitterTriangles = 8000000; // eight bytes each
const char* const kTables = "stf";                     // integrators
const char* const kTraced = "reference";
/// Full angle, degrees, of a distant light whose disc is too small for paths that are refracted to meet.
constexpr float kLeastMetAngle = 4.1f;
constexpr int kBlock = 4; // pixels, of rays that are traced together
static_assert(kBlock * kBlock == kMostTogether && kTile % kBlock == 0);

double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::shared_ptr<const StfTable> computeTable(const std::shared_ptr<const BaseVolume>& volume,
                                             const TransportOptions& options, Progress& progress,
                                             const MessageSink& messages) {
    return std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
}

PixelFilter filterOf(const RenderSettings& settings) {
    PixelFilter::Shape shape = PixelFilter::Shape::Box;
    if (!PixelFilter::shapeFromName(settings.pixelFilter, shape)) {
        throw Error("no pixel filter \"" + settings.pixelFilter +
                    "\"; there are box, triangle, gaussian, blackmanHarris");
    }
    return PixelFilter(shape, settings.pixelFilterWidth);
}

const std::string& materialIdOf(const SceneMesh& m, int part) {
    return part > 0 && std::size_t(part) <= m.partMaterials.size() ? m.partMaterials[std::size_t(part - 1)]
                                                                   : m.material;
}

// Whether the shells of one are those of the other.
bool shellsAgree(const RenderSettings& a, const RenderSettings& b) {
    return a.quality == b.quality && a.tableSeed == b.tableSeed && a.transport == b.transport &&
           a.integrator == b.integrator && a.exact == b.exact;
}

} // namespace

struct Renderer::Impl {
    Impl(TableProvider tables, MapProvider maps, PathTracerProvider traced)
        : reference(std::move(traced)),
          builder(tables ? std::move(tables) : TableProvider(computeTable), std::move(maps),
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
        RenderSettings settings;
        struct Part {
            std::shared_ptr<const PreparedMesh> mesh;
            int number = 0;        // of ControlMesh::faceParts
            bool standsIn = false; // for a shell that is still to come, by its displayColor
        };
        std::vector<Part> parts; // none where nothing can be drawn
        std::vector<PlanEntry> plan;
    };

    /// A mesh with a shell is whole.
    static const ShellObject* shellOf(const Kept& k) {
        return k.parts.empty() ? nullptr : k.parts.front().mesh->shell.get();
    }
    void prepareMesh(const std::string& id, const SceneMesh& m, double metersPerUnit, Kept& kept, Progress& progress);
    bool upToDate(const Scene& source) const;
    /// Everything but the light between surfaces. `draft`: shells as they are, those that are not there yet as plain.
    void place(const Scene& source, bool draft, Progress& progress);
    void placeInstances(const Scene& source);
    std::size_t placeLights();
    void planSurfaces();
    void planCamera(const Scene& source);
    void chooseCamera();
    std::uint64_t pixelNumber(int x, int y) const;
    bool blursMotion() const {
        return camera.moves() || std::any_of(scene->instances.begin(), scene->instances.end(),
                                             [](const PreparedInstance& i) { return !i.motion.empty(); });
    }
    std::shared_ptr<const PlainMaterial> materialOf(const std::string& material, const Scene& source);
    bool traces() const { return settings.integrator != kTables; }
    LightSet lightsOf(const Scene& source);
    void balanceLight(Progress& progress);
    void keepLight();
    void takeKeptLight();
    void sampleBlock(Integrator& integrator, PathTracer* traced, int x0, int y0, std::uint32_t pass,
                     const RayCone& cone, bool motion, int stride);
    bool tileGoesOn(int x0, int y0, std::uint32_t pass) const;
    void restartSampling() {
        adaptive.restart(film.width(), film.height());
        passDone.assign(std::size_t(film.width()) * std::size_t(film.height()), 0);
    }

    std::mutex messageMutex;
    MessageSink sink;
    std::set<std::string> said;

    RenderSettings settings;
    PixelFilter filter;
    Camera givenCamera, camera; ///< as the host says, and as the settings have it
    FrameWindow window;
    Film film;
    PathTracerProvider reference;
    PathTracerMaker tracer; ///< of the prepared scene, where it is path traced
    ShellBuilder builder;
    LightBalance balance;
    std::map<std::string, Kept> kept;
    TextureStore textures;
    std::map<std::string, std::shared_ptr<const PlainMaterial>> materials; // of what is drawn
    std::unique_ptr<PreparedScene> scene;
    /// Light between surfaces as it was solved last, while the scene has none: what a draft shows.
    struct KeptLight {
        struct OfInstance {
            std::weak_ptr<const PreparedMesh> mesh; // which may go meanwhile
            std::vector<Rgb> core, exitant;
            IndirectLight indirect;
        };
        std::vector<OfInstance> instances;
        bool shellsSeeOthers = false, keepsDomes = false;
    };
    std::optional<KeptLight> keptLight;
    bool lightSolved = false;      ///< the instances have it
    std::set<std::string> objects; ///< names of what is drawn
    Rgb clearColor{0.0f};
    float clearAlpha = 0;
    std::uint64_t preparedVersion = 0, lightVersion = 0;
    Shutter preparedShutter;
    bool hasMotion = false;          ///< some instance has samples of its way
    RenderSettings preparedSettings; ///< tables depend on quality and form, the core's samples on the seed
    int passes = 0;
    AdaptiveSampling adaptive;
    std::vector<std::uint32_t> passDone; ///< per pixel, passes that it took part in or was spared
    RenderStats stats;
    double error = 0; ///< of the image after `errorAt` passes
    int errorAt = 0;
    std::vector<PlanEntry> scenePlan;
    Clock::time_point prepareStart;
};

void Renderer::Impl::prepareMesh(const std::string& id, const SceneMesh& m, double metersPerUnit, Kept& k,
                                 Progress& progress) {
    k.meshVersion = m.meshVersion;
    k.stfVersion = m.stfVersion;
    k.metersPerUnit = metersPerUnit;
    k.settings = settings;
    k.parts.clear();
    k.plan.clear();
    ControlMesh mesh = *m.mesh;
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
            auto prepared = std::make_shared<PreparedMesh>();
            auto shell =
                builder.build(id, mesh, m.refineLevel, *m.stf, metersPerUnit, settings, progress, stats, k.plan);
            prepared->surface = shell->surface;
            prepared->rayMesh = shell->rayMesh;
            prepared->shell = shell;
            k.parts = {{prepared, 0}};
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
        options.pointNormals = !mesh.faceParts.empty(); // parts have corners' normals
        if (mesh.scheme != ControlMesh::Scheme::None) {
            Box3f box;
            for (const Vec3f& p : mesh.points) {
                box.add(p);
            }
            options.targetEdge = box.diagonal() / 100;
            options.maxEdgeTriangles = 20'000; // scenes may have thousands of meshes
        }
        RefinedSurface whole =
            refine(mesh, options, [&](Severity s, const std::string& text) { say(s, id + ": " + text); });
        for (SurfacePart& part : splitByPart(std::move(whole), mesh.faceParts)) {
            auto prepared = std::make_shared<PreparedMesh>();
            prepared->surface = std::make_shared<const RefinedSurface>(std::move(part.surface));
            prepared->rayMesh =
                std::make_shared<const RayMesh>(prepared->surface->points, prepared->surface->triangles);
            k.parts.push_back({prepared, part.number});
        }
    } catch (const Error& e) {
        say(Severity::Error, id + ": mesh " + e.what());
    }
}

// Only what a plain surface shows is looked up, and only what changed is made anew.
std::shared_ptr<const PlainMaterial> Renderer::Impl::materialOf(const std::string& material, const Scene& source) {
    const auto it = source.materials().find(material);
    if (it == source.materials().end()) {
        return nullptr;
    }
    std::shared_ptr<const PlainMaterial>& made = materials[material];
    if (!made || !(made->surface() == it->second)) {
        made = std::make_shared<const PlainMaterial>(material, it->second, textures,
                                                     [this](Severity s, const std::string& text) { say(s, text); });
    }
    return made;
}

// Lights where the scene is, and the meshes that shine, as far as samples of them agree with rays that meet them: the
// same all over, whole, at rest. The others give light to whom they meet. How many meshes.
std::size_t Renderer::Impl::placeLights() {
    std::vector<MeshEmitter> emitters;
    std::size_t triangles = 0;
    for (const PreparedInstance& i : scene->instances) {
        const PlainMaterial* const m = i.material.get();
        if (m && m->emits() && m->opaque() && i.motion.empty() && !m->surface().emissiveColor.texture) {
            triangles += i.mesh->surface->triangles.size();
            if (triangles > kMostEmitterTriangles) {
                say(Severity::Warning, "meshes that shine have more than " + std::to_string(kMostEmitterTriangles) +
                                           " triangles: the rest of them is found by bounces alone");
                break;
            }
            emitters.push_back({i.mesh->surface, i.objectToWorld, m->emission(), i.index});
        }
    }
    scene->lights.place(scene->origin, emitters);
    return scene->lights.meshCount();
}

// Which surfaces there are beside shells, and what of their light is followed.
void Renderer::Impl::planSurfaces() {
    scenePlan.erase(std::remove_if(scenePlan.begin(), scenePlan.end(),
                                   [](const PlanEntry& e) { return e.stage == "materials" || e.stage == "bounces"; }),
                    scenePlan.end());
    int plain = 0, read = 0, clear = 0;
    std::set<const PlainMaterial*> used;
    scene->surfacesBounce = false;
    scene->clearShells = false;
    for (const PreparedInstance& i : scene->instances) {
        if (i.mesh->shell) {
            scene->clearShells = scene->clearShells || !i.mesh->shell->medium->refracts();
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

// What of the host's camera the settings let through.
void Renderer::Impl::chooseCamera() {
    camera = settings.depthOfField ? givenCamera : givenCamera.pinhole();
    if (!settings.motionBlur) {
        camera = camera.atRest();
    }
    film.setExposure(std::exp2(camera.optics().exposure));
}

// A pixel's random numbers go by its place in the frame, so that a window shows the same as the whole.
std::uint64_t Renderer::Impl::pixelNumber(int x, int y) const {
    const std::int64_t fx = std::int64_t(x) + window.x, fy = std::int64_t(y) + window.y;
    if (fx >= 0 && fx < window.frameWidth && fy >= 0 && fy < window.frameHeight) {
        return std::uint64_t(fy) * std::uint64_t(window.frameWidth) + std::uint64_t(fx);
    }
    return (std::uint64_t(1) << 63) | (std::uint64_t(std::uint32_t(fy)) << 32) | std::uint64_t(std::uint32_t(fx));
}

void Renderer::Impl::planCamera(const Scene& source) {
    scenePlan.erase(std::remove_if(scenePlan.begin(), scenePlan.end(),
                                   [](const PlanEntry& e) { return e.stage == "lens" || e.stage == "motion"; }),
                    scenePlan.end());
    const bool lens = camera.optics().lens.blurs();
    scenePlan.push_back({"scene", "lens", lens,
                         lens                                ? "circles of confusion by the camera's lens"
                         : givenCamera.optics().lens.blurs() ? "stf:depthOfField is off"
                                                             : "the camera is a pinhole",
                         0});
    std::size_t moving = 0;
    for (const PreparedInstance& i : scene->instances) {
        moving += i.motion.empty() ? 0 : 1;
    }
    const bool runs = moving > 0 || camera.moves();
    const bool open = givenCamera.optics().shutter.blurs();
    scenePlan.push_back({"scene", "motion", runs,
                         runs ? std::string(camera.moves() ? "the camera moves" : "the camera is at rest") +
                                    ", moving instances: " + std::to_string(moving) + " of " +
                                    std::to_string(scene->instances.size()) +
                                    "; lights, cores and points are those of the exposure's middle or the frame"
                         : !open                ? "the shutter opens for no time"
                         : !settings.motionBlur ? "stf:motionBlur is off"
                                                : "nothing moves while the shutter is open",
                         0});
    preparedShutter = camera.optics().shutter;
    hasMotion = std::any_of(source.meshes().begin(), source.meshes().end(), [](const auto& m) {
        return std::any_of(m.second.instances.begin(), m.second.instances.end(),
                           [](const MeshInstance& i) { return i.motion.size() > 1; });
    });
}

void Renderer::Impl::placeInstances(const Scene& source) {
    std::vector<RayInstance> rays;
    scene->instances.clear();
    objects.clear();
    std::set<std::string> bound;
    for (const auto& [id, m] : source.meshes()) {
        if (m.visible) {
            bound.insert(m.material);
            bound.insert(m.partMaterials.begin(), m.partMaterials.end());
        }
    }
    for (auto it = materials.begin(); it != materials.end();) {
        it = bound.count(it->first) && source.materials().count(it->first) ? std::next(it) : materials.erase(it);
    }
    const auto drawn = [&](const std::string& id, const SceneMesh& m) -> const std::vector<Kept::Part>& {
        static const std::vector<Kept::Part> none;
        const auto it = kept.find(id);
        return m.visible && it != kept.end() ? it->second.parts : none;
    };
    // The middle of the scene, in double precision.
    Vec3d low(1e300), high(-1e300);
    for (const auto& [id, m] : source.meshes()) {
        Box3f box;
        for (const Kept::Part& part : drawn(id, m)) {
            box.add(part.mesh->surface->bounds.lo);
            box.add(part.mesh->surface->bounds.hi);
        }
        for (const MeshInstance& i : m.instances) {
            const Vec3d p = i.objectToWorld.point((Vec3d(box.lo) + Vec3d(box.hi)) * 0.5);
            for (int a = 0; a < 3 && !box.empty() && isFinite(p); ++a) {
                low[a] = std::min(low[a], p[a]);
                high[a] = std::max(high[a], p[a]);
            }
        }
    }
    scene->origin = low.x <= high.x ? (low + high) * 0.5 : Vec3d(0.0);
    for (const auto& [id, m] : source.meshes()) {
        const std::vector<Kept::Part>& parts = drawn(id, m);
        if (parts.empty()) {
            continue;
        }
        for (const MeshInstance& i : m.instances) {
            if (!i.objectToWorld.invertible()) {
                say(Severity::Error, id + ": its transform is singular or not finite, it is left out");
                continue;
            }
            PreparedInstance p;
            p.objectToWorld = i.objectToWorld;
            p.objectToWorld.translation -= scene->origin;
            p.motion = motionSteps(i.motion, camera.optics().shutter);
            if (!std::all_of(p.motion.begin(), p.motion.end(), [](const Transform& t) { return t.invertible(); })) {
                say(Severity::Warning,
                    id + ": its transform is singular or not finite while the shutter is open, it is not blurred");
                p.motion.clear();
            }
            for (Transform& step : p.motion) {
                step.translation -= scene->origin;
            }
            if (!p.motion.empty()) {
                p.objectToWorld = atTime(p.motion, 0.5f);
            }
            p.worldToObject = p.objectToWorld.inverse();
            p.primId = m.primId;
            p.instanceId = i.instanceId;
            p.objectId = cryptomatteId(i.name.empty() ? id : i.name);
            p.links = scene->lights.linksOf(m.links) | scene->lights.linksOf(i.links);
            objects.insert(i.name.empty() ? id : i.name);
            for (const Kept::Part& part : parts) {
                PreparedInstance placed = p;
                placed.mesh = part.mesh;
                const std::string& look = materialIdOf(m, part.number);
                placed.material = placed.mesh->shell || part.standsIn ? nullptr : materialOf(look, source);
                if (placed.material && placed.material->usesUvs() && placed.mesh->surface->uvTriangles.empty()) {
                    say(Severity::Warning,
                        id + ": material " + look +
                            " has textures, but the mesh has no texture coordinates; (0, 0) is read");
                }
                placed.index = std::uint32_t(scene->instances.size());
                RayInstance r;
                r.mesh = placed.mesh->rayMesh;
                r.objectToWorld = placed.objectToWorld;
                r.motion = placed.motion;
                r.id = placed.index;
                rays.push_back(r);
                scene->instances.push_back(std::move(placed));
            }
        }
    }
    findOverlaps(scene->instances);
    scene->rays = std::make_unique<const RayScene>(rays);
    const Box3f box = scene->rays->bounds();
    const float farthest = box.empty() ? 1.0f
                                       : std::max(std::max(std::abs(box.lo.x), std::abs(box.hi.x)),
                                                  std::max(std::max(std::abs(box.lo.y), std::abs(box.hi.y)),
                                                           std::max(std::abs(box.lo.z), std::abs(box.hi.z))));
    scene->rounding = 5e-7f * farthest;
    scene->shadowOffset = 1e-5f * box.diagonal() + scene->rounding;
}

Renderer::Renderer(TableProvider tables, MapProvider maps, PathTracerProvider reference)
    : impl_(std::make_unique<Impl>(std::move(tables), std::move(maps), std::move(reference))) {}
Renderer::~Renderer() = default;

void Renderer::setMessages(MessageSink messages) {
    const std::lock_guard<std::mutex> lock(impl_->messageMutex);
    impl_->sink = std::move(messages);
}

void Renderer::setSettings(const RenderSettings& settings) {
    if (settings.integrator != kTables && (settings.integrator != kTraced || !impl_->reference)) {
        throw Error("no integrator \"" + settings.integrator + "\"; there is " + kTables +
                    (impl_->reference ? std::string(" and ") + kTraced : std::string()));
    }
    impl_->filter = filterOf(settings);
    impl_->settings = settings;
    impl_->chooseCamera();
}

void Renderer::setCamera(const Camera& camera, int width, int height) {
    setCamera(camera, {width, height, 0, 0, width, height});
}

void Renderer::setCamera(const Camera& camera, const FrameWindow& window) {
    Impl& s = *impl_;
    s.givenCamera = camera;
    s.chooseCamera();
    s.window = window;
    if (s.film.width() != window.width || s.film.height() != window.height) {
        s.film.resize(window.width, window.height);
        s.restartSampling();
    }
}

void Renderer::setClearColor(const Rgb& color, float alpha) {
    impl_->clearColor = color;
    impl_->clearAlpha = alpha;
}

void Renderer::keepCoverage(bool keep) {
    impl_->film.keepCoverage(keep);
}

std::vector<std::string> Renderer::objectNames() const {
    return {impl_->objects.begin(), impl_->objects.end()};
}

// Light between surfaces, shells and cores depends on the number of bounces.
bool Renderer::Impl::upToDate(const Scene& source) const {
    return scene && settings.maxDepth == preparedSettings.maxDepth &&
           settings.irradianceCache == preparedSettings.irradianceCache && source.version() == preparedVersion &&
           shellsAgree(settings, preparedSettings) && settings.seed == preparedSettings.seed &&
           (!hasMotion || camera.optics().shutter == preparedShutter);
}

void Renderer::Impl::place(const Scene& source, bool draft, Progress& progress) {
    if (!scene) {
        scene = std::make_unique<PreparedScene>();
    }
    preparedVersion = 0;
    scenePlan.clear();
    keepLight();
    // They would keep what is about to be replaced in memory beside its replacement.
    scene->instances.clear();
    scene->rays.reset();
    scene->glow = nullptr;

    for (auto it = kept.begin(); it != kept.end();) {
        it = source.meshes().count(it->first) ? std::next(it) : kept.erase(it);
    }
    for (const auto& [id, m] : source.meshes()) {
        Kept& k = kept[id];
        const bool needed = m.visible && m.mesh && !m.instances.empty();
        const bool current = k.meshVersion == m.meshVersion && k.stfVersion == m.stfVersion &&
                             k.metersPerUnit == source.metersPerUnit() && shellsAgree(k.settings, settings);
        if (needed && !current) {
            if (!draft || !m.stf) {
                prepareMesh(id, m, source.metersPerUnit(), k, progress);
            } else if (k.parts.empty() ||
                       k.settings.integrator != settings.integrator) { // shells of the reference have no tables
                SceneMesh plain = m;
                plain.stf.reset();
                prepareMesh(id, plain, source.metersPerUnit(), k, progress);
                k.meshVersion = 0;
                for (Kept::Part& part : k.parts) {
                    part.standsIn = true;
                }
            }
        } else if (!needed) {
            k.plan = {{id, "mesh", false, m.visible ? "nothing to draw" : "invisible", 0}};
            k.meshVersion = 0;
        }
    }
    if (lightVersion != source.lightVersion() || traces() || tracer) {
        scene->lights = lightsOf(source);
        lightVersion = source.lightVersion();
    }
    tracer = {};
    placeInstances(source);
    planSurfaces();
    planCamera(source);
    const std::size_t emitters = placeLights();
    scenePlan.push_back({"scene", "lights", scene->lights.count() > 0,
                         std::to_string(scene->lights.count() - emitters) + " of " +
                             std::to_string(source.lights().size()) +
                             " give light, meshes that do: " + std::to_string(emitters),
                         0});
}

// What solving anew is about to replace; what was kept before stays where that was cancelled.
void Renderer::Impl::keepLight() {
    if (!lightSolved) {
        return;
    }
    lightSolved = false;
    keptLight.emplace();
    keptLight->shellsSeeOthers = scene->shellsSeeOthers;
    keptLight->keepsDomes = scene->keepsDomes;
    for (PreparedInstance& i : scene->instances) {
        keptLight->instances.push_back({i.mesh, std::move(i.core), std::move(i.exitant), std::move(i.indirect)});
    }
}

void Renderer::Impl::takeKeptLight() {
    scene->shellsSeeOthers = keptLight && keptLight->shellsSeeOthers;
    scene->keepsDomes = keptLight && keptLight->keepsDomes;
    for (std::size_t i = 0; keptLight && i < std::min(scene->instances.size(), keptLight->instances.size()); ++i) {
        PreparedInstance& to = scene->instances[i];
        const KeptLight::OfInstance& from = keptLight->instances[i];
        if (to.mesh == from.mesh.lock()) {
            to.core = from.core;
            to.exitant = from.exitant;
            to.indirect = from.indirect;
        }
    }
}

bool Renderer::prepareDraft(const Scene& source, Progress& progress) {
    Impl& s = *impl_;
    const bool shells = std::any_of(source.meshes().begin(), source.meshes().end(),
                                    [](const auto& m) { return m.second.stf && m.second.visible; });
    if (!shells || s.traces() || s.upToDate(source)) {
        return false;
    }
    setThreadCount(s.settings.threads);
    s.prepareStart = Clock::now();
    s.place(source, true, progress);
    s.scene->maxDepth = s.settings.maxDepth;
    s.scene->irradianceCache = s.settings.irradianceCache;
    s.takeKeptLight();
    return true;
}

void Renderer::prepare(const Scene& source, Progress& progress) {
    Impl& s = *impl_;
    setThreadCount(s.settings.threads);
    s.prepareStart = Clock::now();
    if (s.upToDate(source)) {
        s.planCamera(source);
        return;
    }
    s.place(source, false, progress);
    s.builder.dropUnused();
    const auto emits = [](const PreparedInstance& i) { return i.mesh->shell && i.mesh->shell->medium->emits(); };
    const std::vector<PreparedInstance>& instances = s.scene->instances;
    const auto shines = [&](const PreparedInstance& i) { return emits(i) || (i.material && i.material->emits()); };
    if (s.scene->lights.count() == 0 && std::none_of(instances.begin(), instances.end(), shines)) {
        s.say(Severity::Warning, "the scene has no light that hdStf knows: what is drawn is black");
    }

    // Cores, and light between shells and other surfaces, depend on lights and on whatever throws shadows: any edit of
    // those solves them again, the camera does not.
    s.balanceLight(progress);
    s.lightSolved = !s.traces();
    s.keptLight.reset();
    // What is held now, not what was ever made: edits replace tables and grids.
    s.stats.tableBytes = s.stats.shellBytes = 0;
    std::set<const StfTable*> tables;
    std::set<const ShellGrid*> grids;
    for (const auto& [id, k] : s.kept) {
        if (const ShellObject* shell = Impl::shellOf(k)) {
            if (grids.insert(shell->grid.get()).second) {
                s.stats.shellBytes += shell->grid->memoryBytes();
            }
            if (tables.insert(shell->table.get()).second) {
                s.stats.tableBytes += shell->table->bytes();
            }
        }
    }
    if (s.traces()) {
        s.tracer = s.reference(*s.scene);
    }
    s.preparedSettings = s.settings;
    s.preparedVersion = source.version();
}

void Renderer::Impl::balanceLight(Progress& progress) {
    scene->maxDepth = settings.maxDepth;
    scene->irradianceCache = settings.irradianceCache;
    if (traces()) {
        scenePlan.push_back({"scene", "core", false, "path traced", 0});
        scenePlan.push_back({"scene", "indirect", false, "path traced", 0});
        return;
    }
    const LightBalance::Report r = balance.solve(*scene, settings.maxDepth > 0, settings.seed, progress);
    stats.coreSeconds += r.coreSeconds;
    stats.indirectSeconds += r.indirectSeconds;
    scenePlan.push_back({"scene", "core", r.cores > 0,
                         r.cores > 0 ? "solved for lights and geometry, instances: " + std::to_string(r.cores) +
                                           ", the first: " + r.core
                                     : "no lit shell with a core that scatters",
                         r.coreSeconds});
    std::ostringstream text;
    if (r.gathers > 0) {
        text << r.samples << " samples of shells looked around by " << r.raysPerSample << " rays each, "
             << 100 * r.shellShare << " % of which met shells; rounds of light between shells: " << r.rounds;
        if (r.rounds > 0) {
            text << ", the last changed " << 100 * r.lastChange << " %";
        }
    } else {
        text << (settings.maxDepth > 0 ? "no lit shell" : "stf:maxDepth is 0");
    }
    scenePlan.push_back({"scene", "indirect", r.gathers > 0, text.str(), r.indirectSeconds});
}

// The lights of the scene; where paths are refracted on their way to them they need an extent that can be met.
LightSet Renderer::Impl::lightsOf(const Scene& source) {
    const MessageSink messages = [this](Severity v, const std::string& text) { say(v, text); };
    const bool refracts = std::any_of(kept.begin(), kept.end(), [](const auto& k) {
        return shellOf(k.second) && shellOf(k.second)->medium->refracts();
    });
    if (!traces() || !refracts) {
        return LightSet(source.lights(), messages);
    }
    std::map<std::string, Light> lights = source.lights();
    for (auto& [id, light] : lights) {
        if (light.type == Light::Type::Distant && light.angle < kLeastMetAngle) {
            LightSet::widen(light, kLeastMetAngle);
            std::ostringstream text;
            text << id << ": paths that are refracted cannot meet so small a light; the reference takes "
                 << kLeastMetAngle << " degrees";
            say(Severity::Warning, text.str());
        }
    }
    return LightSet(lights, messages);
}

// Whether some pixel of a tile still takes part in a pass: of an image that is nearly done most tiles cost nothing.
bool Renderer::Impl::tileGoesOn(int x0, int y0, std::uint32_t pass) const {
    for (int y = y0; y < std::min(y0 + kTile, film.height()); ++y) {
        for (int x = x0; x < std::min(x0 + kTile, film.width()); ++x) {
            if (adaptive.active(x, y) &&
                passDone[std::size_t(y) * std::size_t(film.width()) + std::size_t(x)] <= pass) {
                return true;
            }
        }
    }
    return false;
}

// A pass over neighbouring pixels, whose camera rays are traced together.
void Renderer::Impl::sampleBlock(Integrator& integrator, PathTracer* traced, int x0, int y0, std::uint32_t pass,
                                 const RayCone& cone, bool motion, int stride) {
    const int width = film.width(), height = film.height();
    const bool lens = camera.optics().lens.blurs();
    const auto ndc = [&](double x, double y) {
        return Vec2d(2 * (x + window.x) / window.frameWidth - 1, 2 * (y + window.y) / window.frameHeight - 1);
    };
    struct Pixel {
        int x, y;
    } pixels[kMostTogether];
    std::optional<PixelSampler> samplers[kMostTogether];
    Integrator::Bundle middles, bundle;
    for (int y = y0; y < std::min(y0 + kBlock, height); ++y) {
        for (int x = x0; x < std::min(x0 + kBlock, width); ++x) {
            std::uint32_t& done = passDone[std::size_t(y) * std::size_t(width) + std::size_t(x)];
            if (done > pass || !adaptive.active(x, y) || x % stride != 0 || y % stride != 0) {
                continue; // done before this pass was interrupted, or good enough, or between those that come first
            }
            if (pass == 0) {
                const Vec2d at = ndc(x + 0.5, y + 0.5);
                middles.time[middles.count] = 0.5f;
                middles.ray[middles.count++] = camera.ray(at.x, at.y, scene->origin);
            }
            PixelSampler& sampler =
                samplers[bundle.count].emplace(settings.seed, pixelNumber(x, y), film.sampleCount(x, y));
            const Vec2f u = sampler.next2d();
            const Vec2d at = ndc(x + 0.5 + double(filter.offset(u.x)), y + 0.5 + double(filter.offset(u.y)));
            // Numbers are drawn only for what blurs: the others stay what they are without it.
            float time = 0.5f;
            if (lens || motion) {
                const Vec2d onLens = lens ? onUnitDisc(sampler.next2d()) : Vec2d();
                time = motion ? sampler.next1d() : 0.5f;
                bundle.ray[bundle.count] = camera.ray(at.x, at.y, scene->origin, onLens, time);
            } else {
                bundle.ray[bundle.count] = camera.ray(at.x, at.y, scene->origin);
            }
            bundle.time[bundle.count] = time;
            pixels[bundle.count++] = {x, y};
            done = pass + 1;
        }
    }
    integrator.meet(middles);
    for (int i = 0; i < middles.count; ++i) {
        film.setHit(pixels[i].x, pixels[i].y, integrator.firstHit(middles, i, camera));
    }
    if (traced) {
        for (int i = 0; i < bundle.count; ++i) {
            film.add(pixels[i].x, pixels[i].y, traced->sample(bundle.ray[i], bundle.time[i], *samplers[i]));
        }
        return;
    }
    integrator.meet(bundle);
    for (int i = 0; i < bundle.count; ++i) {
        film.add(pixels[i].x, pixels[i].y, integrator.sample(bundle, i, cone, *samplers[i]));
    }
}

void Renderer::restart() {
    impl_->film.clear();
    impl_->restartSampling();
    impl_->passes = 0;
    impl_->stats.rays = 0;
    impl_->stats.renderSeconds = 0;
    impl_->stats.firstPixelSeconds = 0;
}

bool Renderer::renderPass(Progress& progress, int stride) {
    Impl& s = *impl_;
    if (!s.scene || !s.scene->rays || converged()) {
        return true;
    }
    setThreadCount(s.settings.threads);
    s.scene->clearColor = s.clearColor * float(std::exp2(-s.camera.optics().exposure));
    s.scene->clearAlpha = s.clearAlpha;
    s.scene->indirectClamp = s.settings.indirectClamp;
    s.scene->regularize = s.settings.regularize && !s.traces();
    Box3f start; // of camera rays, twice as wide as the picture
    for (const Vec2d& corner : {Vec2d{-2, -2}, Vec2d{2, -2}, Vec2d{-2, 2}, Vec2d{2, 2}}) {
        start.add(s.camera.ray(corner.x, corner.y, s.scene->origin).origin);
    }
    s.scene->aroundCamera = shellsAround(s.scene->instances, start);
    const auto startTime = Clock::now();
    const int width = s.film.width(), height = s.film.height();
    const int tilesX = (width + kTile - 1) / kTile, tilesY = (height + kTile - 1) / kTile;
    const std::uint32_t pass = std::uint32_t(s.passes);
    const bool motion = s.blursMotion();
    s.film.setDenoised({});
    s.adaptive.beforePass(s.film, pass, double(s.settings.errorTarget));
    std::atomic<std::uint64_t> rays{0};
    parallelFor(std::size_t(tilesX) * std::size_t(tilesY), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tile = begin; tile < end && !progress.cancelled(); ++tile) {
            if (!s.tileGoesOn(int(tile) % tilesX * kTile, int(tile) / tilesX * kTile, pass)) {
                continue;
            }
            Integrator integrator(*s.scene);
            const std::unique_ptr<PathTracer> traced = s.tracer ? s.tracer() : nullptr;
            const int x0 = int(tile) % tilesX * kTile, y0 = int(tile) / tilesX * kTile;
            // Of the pixel in the tile's middle: it hardly changes within.
            const RayCone cone =
                s.camera.cone(2 * (x0 + 0.5 * kTile + s.window.x) / s.window.frameWidth - 1,
                              2 * (y0 + 0.5 * kTile + s.window.y) / s.window.frameHeight - 1, 2.0 / s.window.frameWidth,
                              2.0 / s.window.frameHeight, s.settings.samples);
            for (int y = y0; y < y0 + kTile; y += kBlock) {
                for (int x = x0; x < x0 + kTile; x += kBlock) {
                    s.sampleBlock(integrator, traced.get(), x, y, pass, cone, motion, stride);
                }
            }
            rays += integrator.rays() + (traced ? traced->rays() : 0);
        }
    });
    s.stats.rays += rays;
    s.stats.renderSeconds += since(startTime);
    if (progress.cancelled()) {
        return false;
    }
    if (!(s.stats.firstPixelSeconds > 0)) {
        s.stats.firstPixelSeconds = since(s.prepareStart);
    }
    s.passes += stride == 1 ? 1 : 0;
    return true;
}

void Renderer::denoise() {
    Impl& s = *impl_;
    DenoiserInput in;
    in.width = s.film.width();
    in.height = s.film.height();
    s.film.setDenoised({});
    const std::vector<float> rgba = s.film.read(Aov::Color);
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
        in.color.insert(in.color.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
    }
    if (!s.camera.optics().lens.blurs() && !s.blursMotion()) {
        in.albedo = s.film.read(Aov::Albedo);
        in.normal = s.film.read(Aov::Normal);
    }
    const auto start = Clock::now();
    const auto plan = [&](bool runs, const std::string& why) {
        s.scenePlan.erase(std::remove_if(s.scenePlan.begin(), s.scenePlan.end(),
                                         [](const PlanEntry& e) { return e.stage == "denoise"; }),
                          s.scenePlan.end());
        s.scenePlan.push_back({"scene", "denoise", runs, why, since(start)});
    };
    try {
        s.film.setDenoised(Denoiser::denoise(in));
        plan(true, in.albedo.empty() ? "by colour" : "by colour, albedo and normal");
    } catch (const Error& e) {
        plan(false, e.what());
        s.say(Severity::Warning, std::string(e.what()) + "; the image is not denoised");
    }
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
    // Looks at every pixel: not after each of many passes.
    Impl& s = *impl_;
    if (s.passes < s.errorAt || s.passes > s.errorAt + s.errorAt / 16 || converged()) {
        s.error = s.film.relativeError();
        s.errorAt = s.passes;
    }
    stats.estimatedError = s.error;
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
