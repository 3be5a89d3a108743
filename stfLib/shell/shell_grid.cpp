// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_grid_impl.h"

#include "stfLib/base/parallel.h"
#include "stfLib/shell/shell_measure.h"

#include <chrono>
#include <cstdio>

namespace stf {

namespace {

constexpr std::size_t kProbes = 8192;
constexpr double kBytesPerSample = 40;      ///< with its share of leaves
constexpr double kCoarsestFirst = 0.25;      ///< of the thickness: no finest level is coarser
constexpr double kFinestOfThickness = 64;   ///< voxels across the shell at most, unless set by hand
constexpr double kTypicalWrongShare = 0.12; ///< of points within a voxel of a seam, measured: where to begin
constexpr int kMostLevels = 12;
constexpr double kErrorOfFootprint = 0.1; ///< a level's error may be such a share of a pixel's footprint
constexpr double kSeamOfFootprint = 0.1;  ///< and the mean displacement of its seams such a share

/// Samples of a shell at a voxel size: area times thickness and margins, curvature left aside.
double estimatedSamples(const ShellSource& source, double voxel) {
    double volume = 0;
    for (const Vec3i& t : source.surface.triangles) {
        const Vec3d p(source.surface.points[std::size_t(t.x)]);
        const double area = 0.5 * length(cross(Vec3d(source.surface.points[std::size_t(t.y)]) - p,
                                               Vec3d(source.surface.points[std::size_t(t.z)]) - p));
        double thickness = 0;
        for (int c = 0; c < 3; ++c) {
            thickness += double(source.boundary.thickness[std::size_t(t[c])]) / 3;
        }
        const double cell = area * (thickness + 2 * kShellMargin * voxel);
        volume += std::isfinite(cell) ? cell : 0.0;
    }
    return volume / (voxel * voxel * voxel);
}

/// That a closed surface encloses, by the divergence theorem; negative where it is inside out.
double signedVolume(const RefinedSurface& surface) {
    const Vec3d middle(surface.bounds.lo);
    double sum = 0;
    for (const Vec3i& t : surface.triangles) {
        const auto corner = [&](int i) { return Vec3d(surface.points[std::size_t(i)]) - middle; };
        sum += dot(corner(t.x), cross(corner(t.y), corner(t.z))) / 6;
    }
    return sum;
}

double thickest(const ShellBoundary& boundary) {
    double most = 0;
    for (float t : boundary.thickness) {
        most = std::max(most, std::isfinite(t) ? double(t) : 0.0);
    }
    if (!(most > 0)) {
        throw Error("the shell has no thickness");
    }
    return most;
}

void check(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map) {
    const std::size_t corners = 3 * surface.triangles.size();
    if (surface.triangles.empty() || surface.bounds.empty()) {
        throw Error("the surface has no triangles");
    }
    if (surface.normals.size() != surface.points.size() || boundary.inner.size() != surface.points.size() ||
        boundary.thickness.size() != surface.points.size()) {
        throw Error("the shell's boundary does not belong to its surface");
    }
    if (map.cornerCoords.size() != corners || map.gradientX.size() != corners || map.gradientY.size() != corners ||
        !(map.tileMm.x > 0 && map.tileMm.y > 0)) {
        throw Error("the exemplar coordinates do not belong to the surface");
    }
}

/// Builds levels until errors are met.
class Builder {
public:
    Builder(const ShellSource& source, const ShellGridOptions& options, ShellGridData& grid, Progress& progress,
            const MessageSink& messages)
        : source_(source), options_(options), grid_(grid), progress_(progress), messages_(messages),
          thickness_(thickest(source.boundary)),
          texelMm_(options.texelMm > 0 ? options.texelMm : std::min(grid.tileMm.x, grid.tileMm.y) / 64) {
        grid_.texelMm = texelMm_;
    }

    void run() {
        progress_.update("shell grid", 0);
        const ShellEdges edges = findEdges(source_.surface, source_.map);
        grid_.report.seamLength = edges.seamLength;
        grid_.report.rimEdges = edges.rims;
        grid_.report.rimLength = edges.rimLength;
        grid_.report.crowdedEdges = edges.crowded;
        grid_.report.turnedEdges = edges.turned;
        grid_.report.insideOut = !edges.rims && !edges.crowded && !edges.turned && signedVolume(source_.surface) < 0;
        const bool byHand = options_.voxelSize > 0 && std::isfinite(options_.voxelSize);
        const double first = byHand ? double(options_.voxelSize) : firstGuess(edges);
        probes_ = makeProbes(source_, edges, kProbes, std::max(thickness_, first));
        grid_.report.probes = probes_.size();
        const double finest = byHand ? limited(first) : refine(first);
        buildLevels(finest);
        grid_.report.errorMet = byHand || met(grid_.reports.front());
        reportProblems(byHand);
        progress_.update("shell grid", 1);
    }

private:
    /// What seams ask for, where they do; else the coarsest.
    double firstGuess(const ShellEdges& edges) const {
        const double coarsest = kCoarsestFirst * thickness_;
        if (edges.seams.empty() || !(options_.seamTexels > 0)) {
            return coarsest;
        }
        const double voxelMm = options_.seamTexels * texelMm_ / (2 * kTypicalWrongShare);
        return std::clamp(voxelMm / source_.mmPerUnit, thickness_ / kFinestOfThickness, coarsest);
    }

    bool met(const ShellLevelReport& r) const {
        return r.errorTexels() <= options_.errorTexels &&
               (!(options_.seamTexels > 0) || r.seamTexels <= options_.seamTexels);
    }

    /// The voxel size of the finest level: from coarse to fine, each step as large as the measured error asks for.
    double refine(double voxel) {
        for (int step = 0;; ++step) {
            const double allowed = limited(voxel, false);
            if (allowed > voxel || voxel < thickness_ / kFinestOfThickness) {
                return std::max(allowed, voxel);
            }
            progress_.update("shell grid", std::min(0.3, 0.05 * step));
            ShellLevelReport r;
            grid_.levels.clear();
            grid_.levels.push_back(makeLevel(
                voxel, 0, [this](double) { progress_.update("shell grid", 0.3); }, r));
            measureLevel(grid_, 0, probes_, texelMm_, r);
            if (met(r)) {
                grid_.reports.push_back(r); // this is the finest level
                return voxel;
            }
            grid_.levels.clear();
            // Halved, so that voxels stay a whole part of the thickness; seams move by a share of a voxel.
            double ratio = 0.5;
            if (options_.seamTexels > 0 && r.seamTexels > options_.seamTexels &&
                r.errorTexels() <= options_.errorTexels) {
                ratio = options_.seamTexels / r.seamTexels * 0.95;
            }
            voxel *= std::clamp(ratio, 0.4, 0.8);
        }
    }

    double pyramidBytes(double finest) const {
        double bytes = 0;
        for (const double v : voxelsOf(finest)) {
            bytes += kBytesPerSample * estimatedSamples(source_, v);
        }
        return bytes;
    }

    /// The voxel size or the least one above that fits into memory.
    double limited(double wanted, bool say = true) const {
        double voxel = wanted;
        while (pyramidBytes(voxel) > double(std::max<std::size_t>(options_.maxBytes, 1))) {
            voxel *= 1.03;
        }
        if (voxel > wanted && say) {
            char text[200];
            std::snprintf(text, sizeof text,
                          "the shell grid's voxels are %.3g units instead of %.3g to stay within %zu MB of memory",
                          voxel, wanted, options_.maxBytes >> 20);
            report(messages_, Severity::Warning, text);
        }
        return voxel;
    }

    std::vector<double> voxelsOf(double finest) const {
        std::vector<double> voxels{finest};
        const int most = options_.levels > 0 ? std::min(options_.levels, kMostLevels) : kMostLevels;
        while (int(voxels.size()) < most && 2 * voxels.back() <= thickness_ * 1.001) {
            voxels.push_back(2 * voxels.back());
        }
        return voxels;
    }

    ShellLevel makeLevel(double voxel, std::size_t firstNumber, const std::function<void(double)>& progress,
                         ShellLevelReport& r) {
        const auto start = std::chrono::steady_clock::now();
        ShellLevel level;
        level.voxel = voxel;
        level.origin = Vec3d(source_.surface.bounds.lo);
        const double outside = kShellMargin * voxel;
        level.codec.tileMm = grid_.tileMm;
        level.codec.depthLow = -outside * source_.mmPerUnit;
        level.codec.depthStep = (thickness_ + 2 * outside) * source_.mmPerUnit / 65535;
        grid_.report.unusableTriangles = scanShell(source_, level, progress).unusableTriangles;
        if (firstNumber + level.sampleCount() > std::size_t(UINT32_MAX)) {
            throw Error("the shell has more than 2^32 voxels");
        }
        level.finish(std::uint32_t(firstNumber));
        r.voxel = voxel;
        r.samples = level.sampleCount();
        r.bytes = level.memoryBytes();
        r.foldedVoxels = level.foldedVoxels;
        r.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return level;
    }

    void buildLevels(double finest) {
        const std::vector<double> voxels = voxelsOf(finest);
        std::size_t samples = grid_.sampleCount();
        double done = 0.3;
        for (std::size_t i = grid_.levels.size(); i < voxels.size(); ++i) {
            // The finest is most of the work.
            const double share = i == 0 ? 0.6 : 0.1 / double(voxels.size());
            ShellLevelReport r;
            grid_.levels.push_back(makeLevel(
                voxels[i], samples, [&](double f) { progress_.update("shell grid", done + share * f); }, r));
            samples += r.samples;
            done += share;
            grid_.reports.push_back(r);
        }
        for (std::size_t i = 0; i < voxels.size(); ++i) {
            measureLevel(grid_, int(i), probes_, texelMm_, grid_.reports[i]);
        }
    }

    void reportProblems(bool byHand) const {
        const ShellGridReport& r = grid_.report;
        const ShellLevelReport& finest = grid_.reports.front();
        char text[320];
        if (r.unusableTriangles) {
            report(messages_, Severity::Warning,
                   std::to_string(r.unusableTriangles) + " triangles without area have no shell");
        }
        if (r.insideOut) {
            report(messages_, Severity::Warning, "the surface is inside out: its shell lies around it, not within");
        }
        if (finest.foldedVoxels) {
            std::snprintf(
                text, sizeof text,
                "the shell folds over in %zu of %zu voxels: it is thicker than the surface's curvature allows",
                finest.foldedVoxels, finest.samples);
            report(messages_, Severity::Warning, text);
        }
        if (r.crowdedEdges) {
            std::snprintf(text, sizeof text,
                          "%zu edges belong to more than two triangles: where their shells overlap, the nearer surface "
                          "counts",
                          r.crowdedEdges);
            report(messages_, Severity::Warning, text);
        }
        if (r.turnedEdges) {
            std::snprintf(text, sizeof text,
                          "%zu edges lie between triangles of opposite orientation: the shell lies on both sides there",
                          r.turnedEdges);
            report(messages_, Severity::Warning, text);
        }
        if (!byHand && !r.errorMet) {
            std::snprintf(text, sizeof text,
                          "the shell grid's error is %.2g texels (wanted: %.2g) and %.2g at seams at its finest voxels "
                          "of %.3g units, which %s",
                          finest.errorTexels(), options_.errorTexels, finest.seamTexels, finest.voxel,
                          finest.voxel > thickness_ / kFinestOfThickness
                              ? "the memory limit allows"
                              : "are as fine as is sensible in a shell of that thickness");
            report(messages_, Severity::Warning, text);
        }
    }

    const ShellSource& source_;
    const ShellGridOptions& options_;
    ShellGridData& grid_;
    Progress& progress_;
    const MessageSink& messages_;
    double thickness_, texelMm_;
    std::vector<ProbedPoint> probes_;
};

} // namespace

std::size_t ShellGridData::sampleCount() const {
    std::size_t sum = 0;
    for (const ShellLevel& l : levels) {
        sum += l.sampleCount();
    }
    return sum;
}

ShellGrid::ShellGrid() : impl_(std::make_unique<Impl>()) {}
ShellGrid::~ShellGrid() = default;
ShellGrid::ShellGrid(ShellGrid&&) noexcept = default;
ShellGrid& ShellGrid::operator=(ShellGrid&&) noexcept = default;

ShellGrid ShellGrid::build(const RefinedSurface& surface, const ShellBoundary& boundary, const ExemplarMap& map,
                           const ShellGridOptions& options, Progress& progress, const MessageSink& messages) {
    check(surface, boundary, map);
    ShellGrid grid;
    Impl& impl = *grid.impl_;
    impl.mmPerUnit = options.mmPerUnit;
    impl.tileMm = map.tileMm;
    impl.triangles = surface.triangles;
    impl.points = surface.points.size();
    Builder({surface, boundary, map, options.mmPerUnit}, options, impl, progress, messages).run();
    return grid;
}

std::vector<Rgb> ShellGrid::spreadCoreRadiance(const std::vector<Rgb>& perPoint) const {
    if (perPoint.size() != impl_->points) {
        throw Error("core radiance is not given per point of the surface");
    }
    std::vector<Rgb> spread(impl_->sampleCount());
    for (const ShellLevel& level : impl_->levels) {
        const std::vector<ShellLeaf>& leaves = level.leaves();
        parallelFor(leaves.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t l = begin; l < end; ++l) {
                for (std::uint32_t i = 0; i < leaves[l].count; ++i) {
                    const ShellSample& s = leaves[l].samples[i];
                    const Vec3i& t = impl_->triangles[s.triangle];
                    const float b1 = float(s.b1) / 65535.0f, b2 = float(s.b2) / 65535.0f;
                    spread[leaves[l].number + i] = perPoint[std::size_t(t.x)] * (1 - b1 - b2) +
                                                   perPoint[std::size_t(t.y)] * b1 + perPoint[std::size_t(t.z)] * b2;
                }
            }
        });
    }
    return spread;
}

int ShellGrid::levelCount() const {
    return int(impl_->levels.size());
}

int ShellGrid::levelFor(float footprintMm) const {
    int level = 0;
    for (int i = 1; i < levelCount(); ++i) {
        const ShellLevelReport& r = impl_->reports[std::size_t(i)];
        const double error = impl_->texelMm * r.errorTexels(), seam = impl_->texelMm * r.seamTexels;
        if (error <= kErrorOfFootprint * double(footprintMm) && seam <= kSeamOfFootprint * double(footprintMm) &&
            r.voxel * impl_->mmPerUnit <= double(footprintMm)) {
            level = i;
        } else {
            break;
        }
    }
    return level;
}

float ShellGrid::voxelSize(int level) const {
    if (impl_->levels.empty()) {
        return 0;
    }
    return float(impl_->levels[std::size_t(std::clamp(level, 0, levelCount() - 1))].voxel);
}

const std::vector<ShellLevelReport>& ShellGrid::levels() const {
    return impl_->reports;
}

const ShellGridReport& ShellGrid::report() const {
    return impl_->report;
}

const ShellGridData& ShellGrid::data() const {
    return *impl_;
}

std::size_t ShellGrid::sampleCount() const {
    return impl_->sampleCount();
}

std::size_t ShellGrid::memoryBytes() const {
    std::size_t bytes = impl_->triangles.capacity() * sizeof(Vec3i);
    for (const ShellLevel& l : impl_->levels) {
        bytes += l.memoryBytes();
    }
    return bytes;
}

} // namespace stf
