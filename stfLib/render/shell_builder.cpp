// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_builder.h"

#include "stfLib/optics/property_table.h"
#include "stfLib/synthesis/choose_mapping.h"
#include "stfLib/synthesis/synthesize.h"
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/volume_io.h"
#include "stfLib/volume/volume_statistics.h"

#include <chrono>
#include <filesystem>
#include <sstream>

namespace stf {

namespace {

constexpr std::size_t kMostSynthesisTriangles = 4'000'000;
constexpr double kSeamTexels = 0.3; ///< wanted mean displacement of seams by the shell grid

class Timer {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Mean diffusion length of the filled voxels, mm: the distance over which multiple scattering blurs shadows.
double blurLengthMm(const BaseVolume& v) {
    const MeanCoefficients mean = meanCoefficients(v);
    const double sigmaA = average(mean.sigmaA), sigmaS = average(mean.sigmaSPrime);
    if (!(sigmaS > 0)) {
        return 0;
    }
    return sigmaA > 0 ? 1 / std::sqrt(3 * sigmaA * (sigmaA + sigmaS)) : 1e9;
}

// The core of the base volume, unless the binding names a material or coefficients; the latter win.
CoreMaterial coreOf(const StfBinding& binding, const BaseVolume& volume, std::string& why,
                    const MessageSink& messages) {
    CoreMaterial core;
    if (binding.coreModel == "none") {
        why = "coreModel is none";
        return core;
    }
    core.sigmaA = volume.coreSigmaA;
    core.sigmaSPrime = volume.coreSigmaSPrime;
    if (!binding.coreMaterial.empty()) {
        try {
            const Material material = PropertyTable::builtIn().find(binding.coreMaterial);
            core.sigmaA = material.sigmaA;
            core.sigmaSPrime = material.sigmaSPrime();
        } catch (const Error& e) {
            report(messages, Severity::Error,
                   std::string("stf:coreMaterial: ") + e.what() + "; the core of the base volume is used");
        }
    }
    if (binding.coreSigmaA) {
        core.sigmaA = Vec3d(*binding.coreSigmaA);
    }
    if (binding.coreSigmaSPrime) {
        core.sigmaSPrime = Vec3d(*binding.coreSigmaSPrime);
    }
    if (!isFinite(core.sigmaA) || !isFinite(core.sigmaSPrime) || minComponent(core.sigmaA) < 0 ||
        minComponent(core.sigmaSPrime) < 0) {
        throw Error("core coefficients must be finite and not negative");
    }
    why = core.scatters() ? "dipole" : "the core does not scatter";
    return core;
}

// The form that a binding, or else the render setting asks for.
TransportForm formOf(const StfBinding& binding, const RenderSettings& settings, const MessageSink& messages) {
    try {
        return parseTransportForm(binding.transport.empty() ? settings.transport : binding.transport);
    } catch (const Error& e) {
        const TransportForm form = TransportOptions().form;
        report(messages, Severity::Error, std::string("stf:transport: ") + e.what() + "; " + name(form) + " is used");
        return form;
    }
}

// Reads now what rendering will ask for: a damaged file is reported with its prim, not met in the middle of a frame.
void readParts(const StfTable& table, const TileMedium& medium, bool coreBlack) {
    if (medium.scatters()) {
        table.multiple.get();
        table.single.get();
        if (medium.emits()) {
            table.emitted.get();
        }
    }
    if (!coreBlack) {
        table.transmitted.get();
        table.direct.get();
        if (medium.scatters()) {
            table.backlight.get();
        }
    }
}

std::string describe(const StfTable& table, const TileMedium& medium) {
    std::ostringstream s;
    s << name(table.form);
    if (!medium.scatters()) {
        s << ", nothing scatters";
        return s.str();
    }
    s.precision(2);
    s << ", " << table.directions.count() << " directions, rank " << table.multiple->rank << ", error "
      << 100 * table.error.total() << " %";
    return s.str();
}

// Exemplar coordinates of a shell's surface, which is sampled more finely where they are synthesised.
void mapSurface(const MappingChoice& choice, const StfBinding& binding, ShellObject& o, Progress& progress,
                const MessageSink& messages) {
    const Vec3d extent = o.volume->extentMm();
    const double mmPerUnit = double(o.mmPerUnit);
    switch (choice.mapping) {
    case Mapping::Uv:
        o.map = tileByUv(o.surface, {extent.x, extent.y}, 1 / mmPerUnit, messages);
        return;
    case Mapping::Anywhere:
        o.map = mapAnywhere(o.surface, {extent.x, extent.y}, 1 / mmPerUnit);
        return;
    case Mapping::Synthesize:
        o.surface = sampleSurface(std::move(o.surface), std::max(o.volume->voxelMm.x, o.volume->voxelMm.y), mmPerUnit,
                                  kMostSynthesisTriangles, messages);
        SynthesisOptions options;
        options.seed = std::uint64_t(std::uint32_t(binding.seed));
        o.map = exemplarMap(synthesize(o.surface, *o.volume, mmPerUnit, options, progress));
        return;
    }
}

} // namespace

void ShellBuilder::dropUnused() {
    for (auto it = volumes_.begin(); it != volumes_.end();) {
        it = it->second.volume.use_count() <= 1 ? volumes_.erase(it) : std::next(it);
    }
    for (auto it = transports_.begin(); it != transports_.end();) {
        const CachedTransport& t = it->second;
        it = t.table.use_count() <= 1 && t.medium.use_count() <= 1 ? transports_.erase(it) : std::next(it);
    }
}

std::shared_ptr<const BaseVolume> ShellBuilder::volume(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code error;
    const auto modified = fs::last_write_time(path, error).time_since_epoch().count();
    const auto size = fs::file_size(path, error);
    CachedVolume& c = volumes_[path];
    if (!c.volume || c.modified != modified || c.size != size) {
        c.volume = std::make_shared<const BaseVolume>(readBaseVolume(path, messages_));
        c.modified = modified;
        c.size = size;
    }
    return c.volume;
}

std::shared_ptr<ShellObject> ShellBuilder::build(const std::string& id, const ControlMesh& mesh, int refineLevel,
                                                 const StfBinding& binding, double metersPerUnit,
                                                 const RenderSettings& settings, Progress& progress, RenderStats& stats,
                                                 std::vector<PlanEntry>& plan) {
    const auto note = [&](const char* stage, bool runs, const std::string& why, double seconds) {
        plan.push_back({id, stage, runs, why, seconds});
    };
    const MessageSink messages = [&](Severity severity, const std::string& text) {
        report(messages_, severity, id + ": " + text);
    };
    const std::string asset = binding.authoredPath.empty() ? binding.baseVolume : binding.authoredPath;
    if (binding.baseVolume.empty()) {
        throw Error("base volume '" + asset + "' was not found");
    }
    if (!(binding.scale > 0) || !std::isfinite(binding.scale)) {
        throw Error("stf:scale must be positive and finite");
    }
    if (!(binding.thickness >= 0) || !std::isfinite(binding.thickness)) {
        throw Error("stf:thickness must be finite and not negative");
    }

    const float quality = binding.quality > 0 ? binding.quality : settings.quality;
    if (!(quality > 0) || !std::isfinite(quality)) {
        throw Error("stf:quality must be positive and finite");
    }

    auto object = std::make_shared<ShellObject>();
    ShellObject& o = *object;
    Timer load;
    o.source = o.volume = volume(binding.baseVolume);
    stats.loadSeconds += load.seconds();
    note("load", true, asset, load.seconds());

    // The shell is a whole number of layers deep: transport must see the medium that the march sees, and no more.
    o.mmPerUnit = float(metersPerUnit * 1000.0 / double(binding.scale));
    const double depthMm = o.volume->extentMm().z;
    const double wantedMm = binding.thickness > 0 ? double(binding.thickness) * double(o.mmPerUnit) : depthMm;
    if (wantedMm > depthMm * 1.0001) {
        std::ostringstream s;
        s << "stf:thickness is " << wantedMm << " mm, the sample is " << depthMm
          << " mm deep; the shell is as deep as the sample";
        report(messages, Severity::Warning, s.str());
    }
    const int layers =
        std::clamp(int(std::lround(std::min(wantedMm, depthMm) / o.volume->voxelMm.z)), 1, o.volume->size.z);
    if (layers < o.volume->size.z) {
        o.volume = std::make_shared<const BaseVolume>(cropDepth(*o.volume, layers));
    }
    o.thicknessMm = float(o.volume->extentMm().z);
    const float thickness = o.thicknessMm / o.mmPerUnit;

    std::string coreWhy;
    o.core = coreOf(binding, *o.volume, coreWhy, messages);
    o.coreBlack = !o.core.scatters();

    Timer precompute;
    TransportOptions options;
    options.quality = quality;
    options.seed = std::uint64_t(std::uint32_t(binding.seed));
    options.form = formOf(binding, settings, messages);
    const std::string key = o.volume->contentHash() + ";" + options.key();
    const auto met = transports_.find(key);
    const bool kept = met != transports_.end();
    CachedTransport transport;
    if (kept) {
        transport = met->second;
    } else {
        transport.medium = std::make_shared<const TileMedium>(*o.volume, options.form);
        transport.table = tables_(o.volume, options, progress, messages);
    }
    try {
        readParts(*transport.table, *transport.medium, o.coreBlack);
    } catch (const Error& e) {
        transports_.erase(key); // it is made again with the next edit
        throw Error(std::string("transport table: ") + e.what());
    }
    transports_[key] = transport;
    o.table = transport.table;
    o.medium = transport.medium;
    stats.precomputeSeconds += precompute.seconds();
    const bool read = !kept && o.table->fileBytes > 0;
    note("transport", !kept && !read && o.medium->scatters(),
         describe(*o.table, *o.medium) + (kept   ? "; already in memory"
                                          : read ? "; kept from an earlier run"
                                                 : ""),
         precompute.seconds());
    if (!o.medium->refracts()) {
        note("fresnel", false, "index 1", 0);
    } else if (!o.medium->hasSurface()) {
        note("fresnel", true, "flat top", 0);
    } else {
        const char* const straight =
            "camera rays enter the relief straight on, with the Fresnel factors of the limit surface";
        note("fresnel", true, straight, 0);
        report(messages, Severity::Warning, std::string("this version does not refract at the relief: ") + straight);
    }

    Timer surface;
    Box3f box;
    for (const Vec3f& p : mesh.points) {
        box.add(p);
    }
    RefineOptions refineOptions;
    refineOptions.level = refineLevel;
    // Fine enough for the shell and for the silhouette, no finer than anyone sees.
    refineOptions.targetEdge = std::clamp(0.6f * thickness, box.diagonal() / 400, box.diagonal() / 60);
    refineOptions.maxTriangles = 600'000;
    o.surface = refine(mesh, refineOptions, messages);
    note("surface", true, std::to_string(o.surface.triangles.size()) + " triangles", surface.seconds());
    Timer synthesis;
    const MappingChoice choice = chooseMapping(binding.mapping, o.surface, *o.volume);
    mapSurface(choice, binding, o, progress, messages);
    stats.synthesisSeconds += surface.seconds();
    note("synthesis", choice.mapping == Mapping::Synthesize, choice.why + "; " + o.map.description,
         synthesis.seconds());

    Timer shell;
    o.boundary = offsetInward(o.surface, thickness, messages);
    ShellGridOptions gridOptions;
    gridOptions.mmPerUnit = double(o.mmPerUnit);
    gridOptions.texelMm = std::min(o.volume->voxelMm.x, o.volume->voxelMm.y);
    if (choice.mapping == Mapping::Synthesize) {
        // Seams run where they are least seen, to a texel: the grid must not move them by more.
        gridOptions.seamTexels = kSeamTexels;
    } else if (choice.mapping == Mapping::Anywhere) {
        gridOptions.voxelSize = 0.25f * thickness; // coordinates do not matter, only the depth
    }
    o.grid = ShellGrid::build(o.surface, o.boundary, o.map, gridOptions, progress, messages);
    o.rayMesh = std::make_shared<const RayMesh>(o.surface.points, o.surface.triangles, o.boundary.inner);
    stats.shellSeconds += shell.seconds();
    note("shell", true,
         std::to_string(o.grid.sampleCount()) + " samples in " + std::to_string(o.grid.levelCount()) + " levels",
         shell.seconds());

    note("core", !o.coreBlack, coreWhy, 0);
    o.blurRadiusMm = float(std::min(blurLengthMm(*o.volume), double(o.thicknessMm)));
    return object;
}

} // namespace stf
