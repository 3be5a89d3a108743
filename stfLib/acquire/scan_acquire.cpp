// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/scan_acquire.h"

#include "stfLib/acquire/gaussian_mixture.h"
#include "stfLib/acquire/level_distance.h"
#include "stfLib/acquire/multi_otsu.h"
#include "stfLib/acquire/scan_classify.h"
#include "stfLib/acquire/scan_view.h"
#include "stfLib/acquire/tile_blend.h"
#include "stfLib/acquire/tile_quilt.h"
#include "stfLib/volume/material_blend.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

// Size of the tile before its sides are joined, and the tile's voxels: a whole number of them fills the extent exactly.
Vec3i tileSize(const ScanRecipe& r, const Vec3i& size, const Vec3d& extentMm) {
    if (!r.voxelMm) {
        return size;
    }
    Vec3i n;
    for (int a = 0; a < 3; ++a) {
        const double cells = std::round(extentMm[a] / (*r.voxelMm)[a]);
        if (cells > double(kMaxVoxels)) {
            throw Error("voxels of " + std::to_string((*r.voxelMm)[a]) + " mm divide " + std::to_string(extentMm[a]) +
                        " mm into too many");
        }
        n[a] = std::max(1, int(cells));
    }
    return n;
}

int solids(const ScanRecipe& r) {
    return int(std::count_if(r.materials.begin(), r.materials.end(), [](const Material& m) { return !m.isVoid(); }));
}

// The largest of what is held at once, in bytes: while reading, while classifying and joining sides, while writing.
double memoryNeeded(const ScanRecipe& r, const ScanReader& reader, const VoxelBox& crop, const Vec3i& size) {
    const double scan = 4.0 * double(crop.voxelCount());
    const double voxels = double(size.x) * size.y * size.z;
    const bool surface = r.surface != ScanRecipe::Surface::None;
    const double field = voxels * (4.0 * solids(r) + (surface ? 4 : 0));
    // extinction, albedo, g, ior, surface; the grids of the file once more, and their packed leaves
    const double volume = voxels * (32 + (surface ? 4 : 0));
    const double reading = scan + double(reader.bufferBytes(crop));
    // A field and the one made of it; quilting keeps a cost with its sums, a surface is smoothed with three copies.
    const double joining = field * (r.tiling == ScanRecipe::Tiling::None ? 1 : 2.5) + (surface ? 16 * voxels : 0);
    return std::max({reading, scan + field, joining, field + volume, 2 * volume + voxels * 8}) + 64e6;
}

void cleanValues(const ScanRecipe& r, Scan& scan, const VoxelBox& crop, AcquiredScan& result) {
    std::size_t first = 0;
    result.lowest = 1e300;
    result.highest = -1e300;
    for (std::size_t i = 0; i < scan.values.size(); ++i) {
        float& v = scan.values[i];
        if (!std::isfinite(v)) {
            first = result.replaced++ == 0 ? i : first;
            if (!r.nan) {
                continue;
            }
            v = float(*r.nan);
        }
        result.lowest = std::min(result.lowest, double(v));
        result.highest = std::max(result.highest, double(v));
    }
    if (result.replaced > 0 && !r.nan) {
        const std::size_t row = std::size_t(scan.size.x), layer = row * std::size_t(scan.size.y);
        throw Error(std::to_string(result.replaced) + " voxels are not finite, the first at " +
                    std::to_string(crop.lo.x + int(first % row)) + ", " +
                    std::to_string(crop.lo.y + int(first / row % std::size_t(scan.size.y))) + ", " +
                    std::to_string(crop.lo.z + int(first / layer)) + " (--nan gives them a value)");
    }
}

TransferFunction transferOf(const ScanRecipe& r, const Scan& scan, AcquiredScan& result) {
    switch (r.method) {
    case ScanRecipe::Method::Transfer:
        return TransferFunction(r.points);
    case ScanRecipe::Method::Thresholds:
        return r.thresholds.empty() ? TransferFunction(std::vector<TransferFunction::Point>{{0, {1.0}}})
                                    : rampsAt(r.thresholds, r.widths);
    default:
        break;
    }
    const ValueHistogram h = histogramOf(scan.values);
    const int k = int(r.materials.size());
    result.classes =
        r.method == ScanRecipe::Method::Gmm ? fitGaussianMixture(h, k) : medianClasses(h, otsuThresholds(h, k));
    return rampsBetween(result.classes);
}

double solidShare(const ScanClassifier& c, double value) {
    std::vector<double> f(c.isVoid.size());
    c.transfer.evaluate(value, f.data());
    double sum = 0;
    for (std::size_t m = 0; m < f.size(); ++m) {
        sum += c.isVoid[m] ? 0 : f[m];
    }
    return sum;
}

// Where the share of material passes one half, if that happens once.
double isoOf(const ScanClassifier& c) {
    const auto& points = c.transfer.points();
    std::vector<double> found;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        double a = 0, b = 0;
        for (std::size_t m = 0; m < c.isVoid.size(); ++m) {
            a += c.isVoid[m] ? 0 : points[i].fractions[m];
            b += c.isVoid[m] ? 0 : points[i + 1].fractions[m];
        }
        if ((a < 0.5) != (b < 0.5)) {
            found.push_back(points[i].value + (0.5 - a) / (b - a) * (points[i + 1].value - points[i].value));
        }
    }
    if (found.size() != 1) {
        std::string where;
        for (const double v : found) {
            where += (where.empty() ? ": at " : ", ") + std::to_string(v);
        }
        throw Error("a surface of its own accord needs one value where material ends and void begins; there are " +
                    std::to_string(found.size()) + where + " (--iso VALUE chooses one)");
    }
    return found[0];
}

LevelRule levelRule(const ScanRecipe& r, const ScanClassifier& c, AcquiredScan& result) {
    LevelRule rule;
    if (r.surface == ScanRecipe::Surface::None) {
        return rule;
    }
    rule.wanted = true;
    rule.iso = r.surface == ScanRecipe::Surface::Auto ? isoOf(c) : r.iso;
    if (!(rule.iso > result.lowest && rule.iso < result.highest)) {
        throw Error("values are " + std::to_string(result.lowest) + " to " + std::to_string(result.highest) +
                    ": none lies on either side of the surface's, " + std::to_string(rule.iso));
    }
    // The side that holds more material; bright where that is the same.
    const double reach = 1e-6 * (result.highest - result.lowest);
    double above = solidShare(c, rule.iso + reach), below = solidShare(c, rule.iso - reach);
    if (above == below) {
        above = solidShare(c, result.highest);
        below = solidShare(c, result.lowest);
    }
    rule.insideAbove = above >= below;
    result.iso = rule.iso;
    return rule;
}

// The first layer that holds material, less one for the surface above it. A layer counts from a thousandth on.
int firstSolidLayer(const TileField& f) {
    const std::size_t layer = std::size_t(f.size.x) * std::size_t(f.size.y);
    for (int z = 0; z < f.size.z; ++z) {
        double solid = 0;
        for (std::size_t i = std::size_t(z) * layer; i < std::size_t(z + 1) * layer; ++i) {
            if (!f.level.empty()) {
                solid += f.level[i] < 0 ? 1 : 0;
            } else {
                for (int m = 0; m < f.materials; ++m) {
                    solid += double(f.at(i)[m]);
                }
            }
        }
        if (solid > 1e-3 * double(layer)) {
            return std::max(0, f.level.empty() ? z : z - 1);
        }
    }
    throw Error("no layer holds material: check the classification and the direction of depth");
}

void cutTop(const ScanRecipe& r, TileField& field, AcquiredScan& result) {
    int first = 0;
    if (r.topAuto) {
        first = firstSolidLayer(field);
    } else if (r.topMm) {
        const double layers = std::round(*r.topMm / field.voxelMm.z);
        if (layers >= field.size.z) {
            throw Error("the top at " + std::to_string(*r.topMm) + " mm lies below the scan's part, " +
                        std::to_string(field.size.z * field.voxelMm.z) + " mm deep");
        }
        first = int(layers);
    }
    result.firstLayer = first;
    if (first > 0) {
        field = layersOf(field, first, field.size.z);
    }
}

void joinTile(const ScanRecipe& r, TileField& field, Progress& progress, AcquiredScan& result) {
    result.before = result.after = periodicityError(field);
    if (r.tiling == ScanRecipe::Tiling::None) {
        return;
    }
    result.overlap = r.overlap ? *r.overlap : Vec3i(std::max(2, field.size.x / 7), std::max(2, field.size.y / 7), 0);
    if (r.tiling == ScanRecipe::Tiling::Quilt) {
        QuiltedTile q = quiltSides(field, result.overlap, progress);
        field = std::move(q.tile);
        result.cut = PeriodicityError{q.cutX, q.cutY};
    } else {
        field = blendSides(field, result.overlap);
    }
    result.after = periodicityError(field);
}

void means(const std::vector<Material>& materials, const std::vector<double>& fractions, Vec3d& sigmaA, Vec3d& sigmaS) {
    for (std::size_t m = 0; m < materials.size(); ++m) {
        sigmaA += materials[m].sigmaA * fractions[m];
        sigmaS += materials[m].sigmaS * fractions[m];
    }
}

// Fractions of all materials of the recipe from those of solid ones; what is missing is shared by the voids' first.
std::vector<double> withVoids(const std::vector<double>& solid, const ScanClassifier& c) {
    std::vector<double> all(c.isVoid.size(), 0.0);
    double missing = 1;
    for (std::size_t m = 0, s = 0; m < all.size(); ++m) {
        if (!c.isVoid[m]) {
            all[m] = solid[s++];
            missing -= all[m];
        }
    }
    const auto firstVoid = std::find(c.isVoid.begin(), c.isVoid.end(), true);
    if (firstVoid != c.isVoid.end()) {
        all[std::size_t(firstVoid - c.isVoid.begin())] = std::max(0.0, missing);
    }
    return all;
}

void setCore(const ScanRecipe& r, const std::vector<Material>& materials, const std::vector<double>& fractions,
             BaseVolume& v) {
    if (r.core) {
        v.coreSigmaA = r.core->sigmaA;
        v.coreSigmaSPrime = r.core->sigmaSPrime();
        return;
    }
    double sum = 0;
    for (std::size_t m = 0; m < materials.size(); ++m) {
        sum += fractions[m];
        v.coreSigmaA += materials[m].sigmaA * fractions[m];
        v.coreSigmaSPrime += materials[m].sigmaSPrime() * fractions[m];
    }
    if (sum > 0) {
        v.coreSigmaA /= sum;
        v.coreSigmaSPrime /= sum;
    }
}

std::unique_ptr<ScanReader> openInput(const ScanRecipe& r, const MessageSink& messages, AcquiredScan& result) {
    auto reader = openScan(r.input, r.read, messages);
    result.header = reader->header();
    result.spacingMm = r.spacingMm.value_or(result.header.spacingMm);
    if (!r.spacingMm && !result.header.spacingKnown) {
        report(messages, Severity::Warning,
               r.input + ": says nothing of the distance of its voxels; taken as " +
                   std::to_string(result.spacingMm.x) + " x " + std::to_string(result.spacingMm.y) + " x " +
                   std::to_string(result.spacingMm.z) + " mm (--spacing)");
    }
    return reader;
}

void acquire(const ScanRecipe& r, Progress& progress, const MessageSink& messages, AcquiredScan& result) {
    const Vec3i axes = axesAlong(r.depth);
    auto reader = openInput(r, messages, result);
    try {
        result.crop = parseCrop(r.crop, result.header.size, result.spacingMm);
        Vec3i viewed;
        Vec3d extent;
        for (int a = 0; a < 3; ++a) {
            viewed[a] = result.crop.size()[axes[a]];
            extent[a] = viewed[a] * result.spacingMm[axes[a]] * r.scale;
        }
        const Vec3i size = tileSize(r, viewed, extent);
        const double voxels = double(size.x) * size.y * size.z;
        result.memoryBytes = memoryNeeded(r, *reader, result.crop, size);
        const std::string ofWhat = "a part of " + sizeText(result.crop.size()) + " voxels of a scan of " +
                                   sizeText(result.header.size) + " (" + nameOf(result.header.type) +
                                   ") into a tile of " + sizeText(size);
        if (voxels > double(kMaxVoxels)) {
            throw Error(ofWhat + " is more than the " + std::to_string(kMaxVoxels) +
                        " voxels that a tile may have (--voxel for larger ones, or --crop)");
        }
        if (result.memoryBytes > r.maxMemoryMB * 1e6) {
            throw Error(ofWhat + " takes " + bytesText(result.memoryBytes) + ", more than the limit of " +
                        bytesText(r.maxMemoryMB * 1e6) + " (--max-memory, --crop or --voxel)");
        }
        Scan scan;
        scan.size = result.crop.size();
        scan.spacingMm = result.spacingMm * r.scale;
        scan.values = reader->read(result.crop, progress);
        reader.reset();
        cleanValues(r, scan, result.crop, result);

        ScanClassifier classifier{transferOf(r, scan, result), {}, r.gradientFlat / r.scale, r.gradientSteep / r.scale};
        std::vector<Material> solid;
        for (const Material& m : r.materials) {
            classifier.isVoid.push_back(m.isVoid());
            result.materials.push_back(m.name);
            if (!m.isVoid()) {
                solid.push_back(m);
            }
        }
        result.transfer = classifier.transfer.points();
        if (solid.empty()) {
            throw Error("all materials are voids");
        }
        const LevelRule level = levelRule(r, classifier, result);
        TileField field = classifyScan(viewAlong(scan, r.depth), classifier, level, size, progress);
        scan.values = {};

        cutTop(r, field, result);
        const std::vector<double> scanMeans = meanFractions(field);
        result.scanFractions = withVoids(scanMeans, classifier);
        means(solid, scanMeans, result.scanSigmaA, result.scanSigmaS);
        joinTile(r, field, progress, result);
        const std::vector<double> tileMeans = meanFractions(field);
        result.tileFractions = withVoids(tileMeans, classifier);
        means(solid, tileMeans, result.tileSigmaA, result.tileSigmaS);

        BaseVolume& v = result.volume;
        v.name = r.name;
        v.size = field.size;
        v.voxelMm = field.voxelMm;
        if (level.wanted) {
            progress.update("surface", 0);
            v.surface =
                signedDistance(field.size, field.voxelMm, smoothLevel(field.size, field.level, r.smooth), progress);
            if (r.smooth > 0) {
                moveToShare(v.size, v.voxelMm, insideShareOfLevel(v.size, v.voxelMm, field.level), v.surface);
            }
            field.level = {};
            result.insideShare = insideShare(v.size, v.voxelMm, v.surface);
            if (v.surface.empty()) {
                report(messages, Severity::Info, "material fills the whole tile: its flat top is the surface");
            }
        }
        progress.update("blend", 0);
        blendMaterials(v, solid, field.fractions);
        setCore(r, solid, tileMeans, v);
        progress.update("blend", 1);
    } catch (const Error& e) {
        const std::string text = e.what();
        throw Error(text.compare(0, r.input.size(), r.input) == 0 ? text : r.input + ": " + text);
    }
}

} // namespace

AcquiredScan acquireScan(const ScanRecipe& recipe, Progress& progress, const MessageSink& messages) {
    AcquiredScan result;
    acquire(recipe, progress, messages, result);
    return result;
}

} // namespace stf
