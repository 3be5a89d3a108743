// SPDX-License-Identifier: Apache-2.0
// Point 11: tables and the files they are made from.
#include "stfLib/transport/precompute.h"
#include "stfLib/volume/vdb_dense.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stability/small_scene.h"

#include <cmath>
#include <fstream>
#include <limits>

namespace stf {

namespace {

// Tables of one light direction, the normal.
StabilityOutcome oneDirection(StabilityRun& run) {
    SmallScene scene(run);
    scene.settings.quality = 0.02f;
    const SmallPicture full = scene.render();
    scene.tables = [](const std::shared_ptr<const BaseVolume>& volume, TransportOptions options, Progress& progress,
                      const MessageSink& messages) {
        options.polars = 1;
        return std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
    };
    const SmallPicture one = scene.render();
    scene.setLightCosine(0.4);
    const SmallPicture oblique = scene.render();
    const double off = one.mean().y / full.mean().y - 1;
    return {measuredText("normal light: %+.2f %%; oblique light: radiance up to %.3f", 100 * off,
                         double(oblique.largest())),
            one.finite() && std::abs(off) < 0.03 && oblique.finite() && oblique.largest() < 1};
}

StabilityOutcome belowHorizon(StabilityRun& run) {
    SmallScene scene(run);
    float most = 0;
    bool finite = true;
    for (const double c : {-1.0, -0.5, -1e-6}) {
        scene.setLightCosine(c);
        const SmallPicture p = scene.render();
        finite = finite && p.finite();
        most = std::max(most, p.largest());
    }
    const DirectionSet set(6, 8);
    const int weights = set.weights({0.6f, 0, -0.8f}).count;
    return {measuredText("largest radiance %g, directions read: %d", double(most), weights),
            finite && most == 0 && weights == 0};
}

StabilityOutcome mixedChannels(StabilityRun& run) {
    SmallScene scene(run);
    BaseVolume& v = scene.volume;
    v.extinction.assign(v.voxelCount(), Rgb(0, 1, 1e3f));
    v.albedo.assign(v.voxelCount(), Rgb(0.9f, 0.9f, 0.9f));
    scene.settings.quality = 0.1f;
    const SmallPicture black = scene.render();
    scene.setCore(0.9);
    const SmallPicture lit = scene.render();
    const Vec3d a = black.mean(), b = lit.mean();
    return {measuredText("over black %.4f %.4f %.4f, over a core %.4f %.4f %.4f", a.x, a.y, a.z, b.x, b.y, b.z),
            black.finite() && lit.finite() && a.x == 0 && b.x > 0.3 && b.y > a.y && std::abs(b.z - a.z) < 1e-6};
}

// Hardly any photon reaches the lower half.
StabilityOutcome unvisited(StabilityRun& run) {
    SmallScene scene(run);
    scene.volume = uniformVolume(4000, 0.5, 0, 16, 2);
    scene.tables = [](const std::shared_ptr<const BaseVolume>& volume, TransportOptions options, Progress& progress,
                      const MessageSink& messages) {
        options.maxPhotons = 300;
        return std::make_shared<const StfTable>(precompute(*volume, options, progress, messages));
    };
    const SmallPicture p = scene.render();
    const auto one = std::make_shared<BaseVolume>(scene.volume);
    TransportOptions options;
    options.maxPhotons = 300;
    const StfTable table = precompute(*one, options, run.progress, {});
    bool finite = true;
    for (float a : table.multiple->factors) {
        finite = finite && std::isfinite(a);
    }
    return {measuredText("table finite: %s; radiance up to %.3f", finite ? "yes" : "no", double(p.largest())),
            finite && p.finite() && p.largest() < 1};
}

openvdb::MetaMap metadata(const Vec3i& size) {
    openvdb::MetaMap m;
    m.insertMeta("stf:version", openvdb::Int32Metadata(1));
    m.insertMeta("stf:size", openvdb::Vec3IMetadata({size.x, size.y, size.z}));
    m.insertMeta("stf:voxel_mm", openvdb::Vec3DMetadata(openvdb::Vec3d(1, 1, 1)));
    return m;
}

// What a scene says that binds a bad file; the object is drawn without its shell.
StabilityOutcome refused(StabilityRun& run, const std::string& name, const std::string& part,
                         const std::function<void(const std::string&)>& write) {
    SmallScene scene(run);
    scene.volumeFile = run.folder.file(name);
    write(scene.volumeFile);
    const SmallPicture p = scene.render();
    const std::string text = p.messages.empty() ? "nothing was said" : p.messages[0];
    const std::size_t slash = text.find(scene.volumeFile);
    const std::string shown = slash == std::string::npos
                                  ? text
                                  : text.substr(0, slash) + text.substr(slash + run.folder.path().string().size() + 1);
    return {shown, p.finite() && p.messages.size() == 1 && p.said("/object") && p.said(name) && p.said(part) &&
                       text.find('\n') == std::string::npos};
}

StabilityOutcome badValue(StabilityRun& run, const char* name, float value) {
    return refused(run, name, "'extinction'", [&](const std::string& path) {
        initializeOpenVdb();
        const Vec3i size{3, 3, 3};
        std::vector<Rgb> k(27, Rgb(0.5f));
        const std::vector<Rgb> albedo = k;
        k[13].y = value;
        writeVdb(path, {toGrid(k, size, Vec3d(1.0), "extinction"), toGrid(albedo, size, Vec3d(1.0), "albedo")},
                 metadata(size));
    });
}

StabilityOutcome emptyFiles(StabilityRun& run) {
    const StabilityOutcome zero = refused(run, "zero.vdb", "not a readable OpenVDB file",
                                          [](const std::string& path) { std::ofstream(path).flush(); });
    const StabilityOutcome none = refused(run, "no_grids.vdb", "'extinction'", [](const std::string& path) {
        initializeOpenVdb();
        writeVdb(path, {}, metadata({3, 3, 3}));
    });
    return {zero.measured + " | " + none.measured, zero.ok && none.ok};
}

} // namespace

void addTableCases(std::vector<StabilityCase>& all) {
    all.push_back({"11.one-direction", "a table of one light direction",
                   "normal light within 3 % of the full table; oblique light finite", false, false, oneDirection});
    all.push_back({"11.below-horizon", "light from below the surface: cosine -1, -.5, -1e-6",
                   "exactly black, no direction read", false, false, belowHorizon});
    all.push_back({"11.mixed-channels", "kappa 0, 1 and 1e3 in red, green and blue, over black and over a core",
                   "finite; red black over black and the core's else, blue does not see the core", false, false,
                   mixedChannels});
    all.push_back({"11.unvisited-voxels", "300 photons in a tile of optical depth 4000", "finite, no brighter than 1",
                   false, false, unvisited});
    all.push_back(
        {"11.nan-voxel", "a volume with a voxel that is no number",
         "one message that names object, file and grid; the rest renders", false, false,
         [](StabilityRun& run) { return badValue(run, "nan.vdb", std::numeric_limits<float>::quiet_NaN()); }});
    all.push_back({"11.negative-voxel", "a volume with a voxel of -1/mm",
                   "one message that names object, file and grid; the rest renders", false, false,
                   [](StabilityRun& run) { return badValue(run, "negative.vdb", -1); }});
    all.push_back({"11.empty-vdb", "a file of no bytes, and one without grids",
                   "one message each that names object and file", false, false, emptyFiles});
}

} // namespace stf
