// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/slab_walk.h"

#include "stfLib/base/parallel.h"
#include "stfLib/transport/walk.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
/// Photons are walked in blocks of fixed size: the sum does not depend on threads, and their scatter is the error of
/// profiles.
constexpr std::uint64_t kProfileBlocks = 256, kMaxBlock = 100'000;
/// Without profiles errors come from the photons themselves, and walks side by side like to be many: the last of a
/// block walk alone.
constexpr std::uint64_t kBlocks = 64;

// A slab as one column of voxels, each 1 mm high whatever its optical depth: only that matters. The column is so wide
// that flights hardly ever leave it to the side.
struct Column {
    BaseVolume volume;
    std::vector<double> edges; ///< optical depths between voxels

    void add(double from, double to, double albedo, double g) {
        volume.extinction.push_back(Rgb(float(to - from)));
        volume.albedo.push_back(Rgb(float(albedo)));
        volume.g.push_back(float(g));
        edges.push_back(to);
    }
};

// Windows around the depths of a profile, thin enough that a window's mean is the value in its middle: at 2 % of a mean
// free path the difference is below 1e-5 of it; near a face, where fluence bends, thinner.
struct Window {
    double from, to;
};
Window windowAround(double depth, double tau) {
    const double scale = std::min(1.0, tau);
    const double width = std::max(1e-4 * scale, std::min({0.02 * scale, 0.1 * depth, 0.1 * (tau - depth)}));
    const double middle = std::clamp(depth, 0.5 * width, tau - 0.5 * width);
    return {middle - 0.5 * width, middle + 0.5 * width};
}

// Voxels end where layers and windows do.
Column makeColumn(const SlabOptions& o, const std::vector<Window>& windows, double coreDepth) {
    std::vector<double> cuts;
    for (const Window& w : windows) {
        cuts.push_back(w.from);
        cuts.push_back(w.to);
    }
    std::sort(cuts.begin(), cuts.end());
    Column c;
    c.edges.push_back(0);
    double top = 0;
    for (const SlabLayer& l : o.layers) {
        double from = top;
        const double bottom = top + l.tau;
        for (double cut : cuts) {
            if (cut > from && cut < bottom) {
                c.add(from, cut, l.albedo, l.g);
                from = cut;
            }
        }
        c.add(from, bottom, l.albedo, l.g);
        top = bottom;
    }
    if (coreDepth > 0) {
        c.add(top, top + coreDepth, o.coreAlbedo, o.coreG);
    }
    c.volume.size = {1, 1, int(c.volume.extinction.size())};
    c.volume.voxelMm = {1e6, 1e6, 1};
    if (o.ior != 1) {
        c.volume.ior.assign(c.volume.voxelCount(), float(o.ior));
    }
    return c;
}

// Mean fluence over a window, per photon, of the first channel.
double windowMean(const Column& c, const Window& w, const std::vector<double>& tracks) {
    double sum = 0, depth = 0, plain = 0, voxels = 0;
    for (std::size_t i = 0; i + 1 < c.edges.size(); ++i) {
        if (c.edges[i] >= w.from && c.edges[i + 1] <= w.to) {
            const double tau = c.edges[i + 1] - c.edges[i];
            sum += tau * tracks[i * 3];
            depth += tau;
            plain += tracks[i * 3];
            voxels += 1;
        }
    }
    return depth > 0 ? sum / depth : voxels > 0 ? plain / voxels : 0;
}

// Mean of blocks and its standard error.
struct BlockMean {
    double sum = 0, squares = 0, weight = 0, blocks = 0;
    void add(double value, double photons) {
        sum += value * photons;
        squares += value * value * photons;
        weight += photons;
        blocks += 1;
    }
    double mean() const { return weight > 0 ? sum / weight : 0; }
    double error() const {
        const double m = mean();
        return blocks > 1 ? std::sqrt(std::max(0.0, squares / weight - m * m) / (blocks - 1)) : 0;
    }
};

// Walks all photons of a source, in blocks and in order; `each` sees every block.
template<class Each>
WalkTally walkBlocks(const TileMedium& medium, const WalkSource& source, WalkRequest request, std::uint64_t photons,
                     const char* stage, Progress& progress, Each&& each) {
    const std::uint64_t wanted = request.voxels ? kProfileBlocks : kBlocks;
    const std::uint64_t block = std::clamp<std::uint64_t>((photons + wanted - 1) / wanted, 1, kMaxBlock);
    const std::uint64_t blocks = (photons + block - 1) / block;
    const std::uint64_t wave = std::uint64_t(4 * threadCount());
    WalkTally total;
    for (std::uint64_t begin = 0; begin < blocks; begin += wave) {
        std::vector<WalkTally> tallies(std::size_t(std::min(wave, blocks - begin)));
        parallelFor(tallies.size(), 1, [&](std::size_t from, std::size_t to) {
            for (std::size_t i = from; i < to; ++i) {
                WalkRequest mine = request;
                mine.first = (begin + i) * block;
                mine.count = std::min(block, photons - mine.first);
                tallies[i] = walk(medium, source, mine, progress);
            }
        });
        for (const WalkTally& t : tallies) {
            each(t);
            total.add(t);
        }
        progress.update(stage, double(begin + tallies.size()) / double(blocks));
    }
    return total;
}

double sum(const std::vector<double>& columns) {
    return columns[0]; // of the first channel, in the only column
}

} // namespace

double slabCoreDepth(double albedo, double g) {
    const double inverse = std::sqrt(3 * (1 - albedo) * (1 - albedo * g));
    return std::clamp(inverse > 0 ? 40 / inverse : 1e5, 2000.0, 1e5);
}

SlabResult slabByWalks(const SlabOptions& o, Progress& progress) {
    const auto start = std::chrono::steady_clock::now();
    SlabResult r;
    r.coreDepth = o.hasCore ? slabCoreDepth(o.coreAlbedo, o.coreG) : 0;
    std::vector<Window> windows;
    for (double depth : o.profile) {
        windows.push_back(windowAround(depth, o.tau()));
    }
    const Column column = makeColumn(o, windows, r.coreDepth);
    const TileMedium medium(column.volume, TransportForm::Classic, !o.hasCore);

    WalkSource source;
    source.kind =
        o.incidence == SlabOptions::Incidence::Diffuse ? WalkSource::Kind::DiffuseTop : WalkSource::Kind::Direction;
    source.towardsLight = {float(std::sqrt((1 - o.mu) * (1 + o.mu))), 0, float(o.mu)};
    WalkRequest request;
    request.seed = o.seed;
    request.voxels = request.uncollided = !windows.empty();
    request.analog = o.analog;

    std::vector<BlockMean> single(windows.size()), multiple(windows.size()), both(windows.size()),
        backlight(windows.size());
    // Fluence per perpendicular irradiance: of the flux mu that it brings.
    const WalkTally t = walkBlocks(medium, source, request, o.photons, "light", progress, [&](const WalkTally& b) {
        const double n = double(b.photons), flux = o.mu;
        for (std::size_t i = 0; i < windows.size(); ++i) {
            const double s = flux * windowMean(column, windows[i], b.uncollided) / n;
            const double m = flux * windowMean(column, windows[i], b.collided) / n;
            single[i].add(s, n);
            multiple[i].add(m, n);
            both[i].add(s + m, n);
        }
    });
    if (!windows.empty()) {
        // As in a table: from a medium of the same index, which takes all that comes back.
        const Column shell = makeColumn(o, windows, 0);
        const TileMedium matched(shell.volume, TransportForm::Classic, false);
        WalkSource below;
        below.kind = WalkSource::Kind::DiffuseBelow;
        request.source = 1;
        walkBlocks(matched, below, request, o.photons, "backlight", progress, [&](const WalkTally& b) {
            const double n = double(b.photons);
            for (std::size_t i = 0; i < windows.size(); ++i) {
                // Unit radiance brings the flux pi.
                backlight[i].add(
                    kPi / (2 * kPi) *
                        (windowMean(shell, windows[i], b.uncollided) + windowMean(shell, windows[i], b.collided)) / n,
                    n);
            }
        });
    }

    const double n = double(o.photons);
    const auto error = [&](double total, double squares) {
        return std::sqrt(std::max(0.0, squares / n - total * total) / std::max(1.0, n - 1));
    };
    r.r = t.above.x / n;
    r.specular = t.specular.x / n;
    r.t = (sum(t.below) + sum(t.belowUncollided)) / n;
    r.unscattered = sum(t.belowUncollided) / n;
    r.a = t.absorbed.x / n;
    r.rError = error(r.r, t.aboveSquared.x);
    r.tError = error(r.t, t.belowSquared.x);
    r.aError = error(r.a, t.absorbedSquared.x);
    r.photons = o.photons;
    r.collisions = t.collisions;
    r.lost = t.lost;
    for (std::size_t i = 0; i < windows.size(); ++i) {
        r.profile.push_back({o.profile[i], single[i].mean(), multiple[i].mean(), backlight[i].mean(), single[i].error(),
                             both[i].error(), multiple[i].error(), backlight[i].error()});
    }
    if (o.hasCore) {
        r.notes.push_back("the core is a layer of optical depth " + std::to_string(std::lround(r.coreDepth)) +
                          "; what it absorbs counts as absorbed");
    }
    if (t.lost) {
        r.notes.push_back(std::to_string(t.lost) + " walks never ended and were dropped");
    }
    r.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return r;
}

} // namespace stf
