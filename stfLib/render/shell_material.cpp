// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/shell_material.h"

#include "stfLib/optics/property_table.h"
#include "stfLib/volume/volume_io.h"
#include "stfLib/volume/volume_statistics.h"

#include <filesystem>
#include <sstream>

namespace stf {

namespace {

constexpr double kLevelError = 0.5; ///< of the tables' own error, by which coarser levels may change radiance

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
    why = core.scatters() ? binding.coreModel == "auto" ? "dipole; walks where the core is thin" : binding.coreModel
                          : "the core does not scatter";
    return core;
}

// Whether pictures are path traced, without tables.
bool isTraced(const ShellStage& stage) {
    return stage.settings.integrator != RenderSettings().integrator;
}

CoreModel modelOf(const StfBinding& binding) {
    return binding.coreModel == "dipole" ? CoreModel::Dipole
           : binding.coreModel == "walk" ? CoreModel::Walk
                                         : CoreModel::Auto;
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

float qualityOf(const StfBinding& binding, const RenderSettings& settings) {
    const float quality = binding.quality > 0 ? binding.quality : settings.quality;
    if (!(quality > 0) || !std::isfinite(quality)) {
        throw Error("stf:quality must be positive and finite");
    }
    return quality;
}

} // namespace

TransportOptions tableOptions(const StfBinding& binding, const RenderSettings& settings, const MessageSink& messages) {
    TransportOptions options;
    options.quality = qualityOf(binding, settings);
    options.seed = settings.tableSeed;
    options.form = formOf(binding, settings, messages);
    options.fineDirections = settings.exact.directions;
    return options;
}

int layersOfShell(const BaseVolume& sample, double wantedMm) {
    const double depth = sample.extentMm().z, wanted = wantedMm > 0 ? std::min(wantedMm, depth) : depth;
    return std::clamp(int(std::lround(wanted / sample.voxelMm.z)), 1, sample.size.z);
}

std::shared_ptr<const BaseVolume> ShellMaterials::volume(const std::string& path) {
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

std::string ShellMaterials::contentHash(const std::shared_ptr<const BaseVolume>& volume) {
    std::string& hash = hashes_[volume];
    if (hash.empty()) {
        hash = volume->contentHash();
    }
    return hash;
}

void ShellMaterials::addLevels(const StfBinding& binding, bool blends, const ShellStage& stage, ShellObject& o) {
    if (isTraced(stage)) {
        o.pyramid = std::make_shared<const TilePyramid>(*o.lit, o.medium, o.table);
        if (blends) {
            o.mixers = {std::make_shared<const HistogramBlend>(*o.medium, nullptr, false)};
            report(stage.messages, Severity::Warning,
                   "the sample is blended over the surface; the reference shows of each point the place of the "
                   "largest weight alone");
        }
        return;
    }
    const StageTimer timer;
    std::ostringstream key;
    key << static_cast<const void*>(o.table.get()) << ";" << static_cast<const void*>(o.medium.get()) << ";"
        << !o.coreBlack << ";" << qualityOf(binding, stage.settings);
    o.pyramid = pyramids_.find(key.str());
    const bool kept = o.pyramid != nullptr;
    if (!kept) {
        o.pyramid = pyramids_.keep(key.str(), TilePyramid(*o.lit, o.medium, o.table, !o.coreBlack,
                                                          kLevelError * double(qualityOf(binding, stage.settings))));
    }
    const std::size_t coarser = o.pyramid->levels().size() - 1;
    std::ostringstream text;
    text.precision(2);
    text << "coarser levels of the sample: " << coarser;
    if (coarser) {
        text << ", errors up to " << 100 * o.pyramid->levels().back().error << " %";
    }
    text << "; " << o.pyramid->why();
    if (coarser) {
        stage.noteKept("prefilter", kept, text.str(), timer.seconds());
    } else {
        stage.note("prefilter", false, text.str(), timer.seconds());
    }
    if (blends) {
        using Mixers = std::vector<std::shared_ptr<const HistogramBlend>>;
        auto mixers = mixers_.find(key.str());
        if (!mixers) {
            Mixers made;
            for (const TilePyramid::Level& l : o.pyramid->levels()) {
                made.push_back(std::make_shared<const HistogramBlend>(*l.medium, l.table.get(), !o.coreBlack));
            }
            mixers = mixers_.keep(key.str(), std::move(made));
        }
        o.mixers = *mixers;
    }
}

void ShellMaterials::dropUnused() {
    mixers_.dropUnused();
    pyramids_.dropUnused();
    crops_.dropUnused();
    for (auto it = volumes_.begin(); it != volumes_.end();) {
        it = it->second.volume.use_count() <= 1 ? volumes_.erase(it) : std::next(it);
    }
    for (auto it = transports_.begin(); it != transports_.end();) {
        const Transport& t = it->second;
        it = t.table.use_count() <= 1 && t.medium.use_count() <= 1 ? transports_.erase(it) : std::next(it);
    }
    for (auto it = hashes_.begin(); it != hashes_.end();) {
        it = it->first.expired() ? hashes_.erase(it) : std::next(it);
    }
}

// The shell is a whole number of layers deep: transport must see the medium that the march sees, and no more.
void ShellMaterials::crop(const StfBinding& binding, const ShellStage& stage, ShellObject& o) {
    const double depthMm = o.source->extentMm().z;
    const double wantedMm = binding.thickness > 0 ? double(binding.thickness) * double(o.mmPerUnit) : depthMm;
    if (wantedMm > depthMm * 1.0001) {
        std::ostringstream s;
        s << "stf:thickness is " << wantedMm << " mm, the sample is " << depthMm
          << " mm deep; the shell is as deep as the sample";
        report(stage.messages, Severity::Warning, s.str());
    }
    const int layers = layersOfShell(*o.source, wantedMm);
    o.volume = o.source;
    if (layers < o.source->size.z) {
        const std::string key = contentHash(o.source) + ";" + std::to_string(layers);
        o.volume = crops_.find(key);
        if (!o.volume) {
            o.volume = crops_.keep(key, cropDepth(*o.source, layers));
        }
    }
    o.thicknessMm = float(o.volume->extentMm().z);
}

// What light is kept for: the shell's voxels, or halves of them. Layout and grid stay as they are.
void ShellMaterials::subdivideLit(const ShellStage& stage, ShellObject& o) {
    o.lit = o.volume;
    if (!o.exact.voxels || isTraced(stage)) {
        return;
    }
    const std::string key = contentHash(o.volume) + ";halves";
    o.lit = crops_.find(key);
    if (!o.lit) {
        try {
            o.lit = crops_.keep(key, subdivide(*o.volume));
        } catch (const Error& e) {
            o.lit = o.volume;
            report(stage.messages, Severity::Warning, std::string("stf:exact: voxels: ") + e.what());
        }
    }
}

void ShellMaterials::addTransport(const StfBinding& binding, const ShellStage& stage, ShellObject& o) {
    const StageTimer timer;
    if (isTraced(stage)) {
        // What the first hits of pixels are found by; there is no light in the table.
        o.medium = std::make_shared<const TileMedium>(*o.lit, TransportForm::Classic);
        o.table = std::make_shared<const StfTable>();
        stage.note("transport", false, "path traced", 0);
        return;
    }
    const TransportOptions options = tableOptions(binding, stage.settings, stage.messages);
    const std::string key = contentHash(o.lit) + ";" + options.key();
    const auto met = transports_.find(key);
    const bool kept = met != transports_.end();
    Transport transport;
    if (kept) {
        transport = met->second;
    } else {
        transport.medium = std::make_shared<const TileMedium>(*o.lit, options.form);
        transport.table = tables_(o.lit, options, stage.progress, stage.messages);
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
    stage.stats.precomputeSeconds += timer.seconds();
    const bool read = !kept && o.table->fileBytes > 0 && !o.table->madeNow;
    stage.note("transport", !kept && !read && o.medium->scatters(),
               describe(*o.table, *o.medium) + (kept   ? "; already in memory"
                                                : read ? "; kept from an earlier run"
                                                       : ""),
               timer.seconds());
    if (!o.medium->refracts()) {
        stage.note("fresnel", false, "index 1", 0);
    } else {
        stage.note("fresnel", true,
                   o.medium->hasSurface() ? "at the relief's surface, and at the top where the relief reaches it"
                                          : "flat top",
                   0);
    }
}

void ShellMaterials::prepare(const StfBinding& binding, double metersPerUnit, const ShellStage& stage, ShellObject& o) {
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
    const StageTimer timer;
    o.source = volume(binding.baseVolume);
    stage.stats.loadSeconds += timer.seconds();
    stage.note("load", true, asset, timer.seconds());

    o.mmPerUnit = float(metersPerUnit * 1000.0 / double(binding.scale));
    o.exact = stage.settings.exact;
    crop(binding, stage, o);
    subdivideLit(stage, o);
    std::string coreWhy;
    o.core = coreOf(binding, *o.volume, coreWhy, stage.messages);
    o.coreModel = modelOf(binding);
    o.coreBlack = !o.core.scatters();
    addTransport(binding, stage, o);
    stage.note("core", !o.coreBlack, coreWhy, 0);
    o.blurRadiusMm = float(std::min(blurLengthMm(*o.volume), double(o.thicknessMm)));
}

} // namespace stf
