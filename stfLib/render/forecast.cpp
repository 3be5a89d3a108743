// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/forecast.h"

#include "stfLib/render/light_set.h"
#include "stfLib/render/shell_material.h"
#include "stfLib/synthesis/choose_mapping.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/volume_io.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

namespace stf {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kPilotPhotons = 200'000;

double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// A table of few photons tells what a photon costs and how noisy it is: noise falls with the root of the photons, and
// has to fit into what the other errors leave of the target.
double tableSeconds(const BaseVolume& volume, TransportOptions options, Progress& progress) {
    const std::uint64_t most = options.maxPhotons;
    options.maxPhotons = kPilotPhotons;
    const auto start = Clock::now();
    const StfTable pilot = precompute(volume, options, progress, {});
    const double seconds = since(start);
    if (pilot.photons == 0 || pilot.error.total() <= double(options.quality)) {
        return seconds; // that was all of it
    }
    const double target = double(options.quality), total = pilot.error.total(), noise = pilot.error.noise;
    const double others = std::sqrt(std::max(0.0, total * total - noise * noise));
    const double left = std::sqrt(std::max(0.25 * target * target, target * target - others * others));
    const double factor = noise > 0 ? (noise / left) * (noise / left) : 1;
    return seconds * std::clamp(factor, 1.0, double(most) / double(pilot.photons));
}

class Forecast {
public:
    Forecast(const Scene& scene, const RenderSettings& settings, const TableKept& kept, Progress& progress)
        : scene_(scene), settings_(settings), kept_(kept), progress_(progress) {}

    std::vector<ForecastEntry> make() {
        for (const auto& [id, m] : scene_.meshes()) {
            if (!m.visible || !m.mesh || m.instances.empty()) {
                add(id, "mesh", false, m.visible ? "nothing to draw" : "invisible");
            } else if (!m.stf) {
                ++plain_;
                add(id, "shell", false, "no base volume is bound");
            } else {
                try {
                    shell(id, m);
                } catch (const Cancelled&) {
                    throw;
                } catch (const std::exception& e) {
                    ++plain_;
                    add(id, "shell", false, e.what());
                }
            }
        }
        const LightSet lights(scene_.lights(), {});
        add("scene", "lights", lights.count() > 0,
            std::to_string(lights.count()) + " of " + std::to_string(scene_.lights().size()) + " give light");
        const bool bounces = plain_ > 0 && settings_.maxDepth > 0;
        add("scene", "bounces", bounces,
            bounces  ? "up to " + std::to_string(settings_.maxDepth) + " off surfaces without a shell"
            : plain_ ? "stf:maxDepth is 0"
                     : "no surface without a shell");
        const bool looks = shells_ > 0 && settings_.maxDepth > 0;
        add("scene", "indirect", looks,
            looks     ? "shells look around for light of other surfaces"
            : shells_ ? "stf:maxDepth is 0"
                      : "no lit shell");
        const bool solves = cores_ > 0 && (lights.count() > 0 || emits_ || bounces);
        add("scene", "core", solves,
            solves ? "is solved for lights and geometry, instances: " + std::to_string(cores_)
                   : "no lit shell with a core that scatters");
        return std::move(plan_);
    }

private:
    void add(const std::string& object, const char* stage, bool runs, const std::string& why,
             std::optional<double> seconds = std::nullopt) {
        plan_.push_back({{object, stage, runs, why, 0}, runs ? seconds : std::optional<double>(0)});
    }

    void shell(const std::string& id, const SceneMesh& m) {
        const StfBinding& binding = *m.stf;
        if (binding.baseVolume.empty()) {
            throw Error("base volume '" + binding.authoredPath + "' was not found");
        }
        ControlMesh mesh = *m.mesh;
        sanitize(mesh);
        const auto start = Clock::now();
        BaseVolume volume = readBaseVolume(binding.baseVolume);
        add(id, "load", true, binding.authoredPath.empty() ? binding.baseVolume : binding.authoredPath, since(start));
        const double mmPerUnit = scene_.metersPerUnit() * 1000 / double(binding.scale);
        const double depth = volume.extentMm().z;
        const MappingChoice choice = mapping(mesh, m.refineLevel, binding, volume, depth / mmPerUnit);
        const int layers = layersOfShell(volume, double(binding.thickness) * mmPerUnit);
        if (layers < volume.size.z) {
            volume = cropDepth(volume, layers);
        }
        transport(id, binding, volume);
        add(id, "synthesis", choice.mapping == Mapping::Synthesize || choice.mapping == Mapping::Blend, choice.why);
        add(id, "shell", true, "the grid of the shell is filled");
        ++shells_;
    }

    MappingChoice mapping(const ControlMesh& mesh, int level, const StfBinding& binding, const BaseVolume& volume,
                          double thickness) const {
        Box3f box;
        for (const Vec3f& p : mesh.points) {
            box.add(p);
        }
        RefineOptions coarse;
        coarse.level = level;
        coarse.targetEdge = std::clamp(0.6f * float(thickness), box.diagonal() / 400, box.diagonal() / 60);
        return chooseMapping(binding.mapping, refine(mesh, coarse, {}), volume);
    }

    void transport(const std::string& id, const StfBinding& binding, const BaseVolume& volume) {
        const TransportOptions options = tableOptions(binding, settings_, {});
        const TileMedium medium(volume, options.form);
        const std::string key = volume.contentHash() + ";" + options.key();
        if (!medium.scatters()) {
            add(id, "transport", false, std::string(name(options.form)) + ", nothing scatters");
        } else if (!made_.insert(key).second) {
            add(id, "transport", false, "the same table as another object's");
        } else if (kept_ && kept_(volume, options)) {
            add(id, "transport", false, "kept from an earlier run");
        } else {
            add(id, "transport", true,
                std::string(name(options.form)) + ", the time by a pilot of " + std::to_string(kPilotPhotons) +
                    " photons",
                tableSeconds(volume, options, progress_));
        }
        add(id, "fresnel", medium.refracts(),
            !medium.refracts()    ? "index 1"
            : medium.hasSurface() ? "at the relief's surface, and at the top where the relief reaches it"
                                  : "flat top");
        Vec3d sigma = volume.coreSigmaSPrime;
        if (binding.coreSigmaSPrime) {
            sigma = Vec3d(*binding.coreSigmaSPrime);
        }
        const bool core = binding.coreModel != "none" && (maxComponent(sigma) > 0 || !binding.coreMaterial.empty());
        cores_ += core ? 1 : 0;
        emits_ = emits_ || medium.emits();
        add(id, "core", core,
            core                          ? binding.coreModel
            : binding.coreModel == "none" ? "coreModel is none"
                                          : "the core does not scatter");
    }

    const Scene& scene_;
    const RenderSettings& settings_;
    const TableKept& kept_;
    Progress& progress_;
    std::vector<ForecastEntry> plan_;
    std::set<std::string> made_;
    int plain_ = 0, shells_ = 0, cores_ = 0;
    bool emits_ = false;
};

} // namespace

std::vector<ForecastEntry> foresee(const Scene& scene, const RenderSettings& settings, const TableKept& kept,
                                   Progress& progress) {
    return Forecast(scene, settings, kept, progress).make();
}

} // namespace stf
