// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/map_walk.h"

#include "stfLib/base/parallel.h"
#include "stfLib/transport/walk.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

namespace stf {

namespace {

/// Their scatter is the error: of 64 it is known to 9 %.
constexpr std::uint64_t kBatches = 64;

// Mean and standard error of batches, channel by channel, by the number of each batch.
template<class Value>
Measured ofBatches(const std::vector<WalkTally>& batches, Value&& value) {
    Measured m;
    const double n = double(batches.size());
    for (const WalkTally& t : batches) {
        m.value += value(t) * (1 / n);
    }
    Vec3d squares{0, 0, 0};
    for (const WalkTally& t : batches) {
        const Vec3d d = value(t) - m.value;
        squares += d * d;
    }
    for (int c = 0; c < 3; ++c) {
        m.error[c] = std::sqrt(squares[c] / (n * (n - 1)));
    }
    return m;
}

} // namespace

void requireFlatTile(const BaseVolume& v) {
    if (v.hasRelief()) {
        throw Error("a map is of a flat tile, and this volume has a relief: its surface lies below the top somewhere");
    }
    for (float n : v.ior) {
        if (n != 1) {
            throw Error("a map is of a tile of index 1, and this volume has an index of refraction of " +
                        std::to_string(n));
        }
    }
    if (!v.emission.empty()) {
        throw Error("a map is of the light alone, and this volume emits");
    }
}

MapResult mapByWalks(const BaseVolume& volume, const MapOptions& o, Progress& progress) {
    const auto start = std::chrono::steady_clock::now();
    requireFlatTile(volume);
    const TileMedium medium(volume, TransportForm::Classic);
    WalkSource source;
    source.towardsLight = o.towardsLight;
    WalkRequest request;
    request.seed = o.seed;
    request.voxels = false;
    if (!o.reflectance) {
        request.towardsViewer = o.towardsViewer;
    }

    // Batches of one size: all weigh the same. What does not divide is rounded up.
    request.count = (o.photons + kBatches - 1) / kBatches;
    std::vector<WalkTally> batches(kBatches);
    std::atomic<std::uint64_t> done{0};
    parallelFor(kBatches, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            WalkRequest mine = request;
            mine.first = b * request.count;
            batches[b] = walk(medium, source, mine, progress);
            progress.update("walks", double(++done) / double(kBatches));
        }
    });

    MapResult r;
    r.width = volume.size.x;
    r.height = volume.size.y;
    const double n = double(request.count), columns = double(r.width) * r.height;
    if (!o.reflectance) {
        // A photon brings cos(light) * tile / n of a unit perpendicular irradiance; a column's radiance is per its
        // area.
        const double scale = double(o.towardsLight.z) * columns / n;
        const auto at = [&](const WalkTally& t, std::size_t i) {
            return Vec3d(t.radiance[3 * i], t.radiance[3 * i + 1], t.radiance[3 * i + 2]) * scale;
        };
        for (std::size_t i = 0; i < std::size_t(columns); ++i) {
            r.columns.push_back(ofBatches(batches, [&](const WalkTally& t) { return at(t, i); }));
        }
        r.mean = ofBatches(batches, [&](const WalkTally& t) {
            Vec3d sum{0, 0, 0};
            for (std::size_t i = 0; i < std::size_t(columns); ++i) {
                sum += at(t, i);
            }
            return sum * (1 / columns);
        });
    }
    WalkTally total;
    for (const WalkTally& t : batches) {
        total.photons += t.photons;
        total.collisions += t.collisions;
        total.lost += t.lost;
        total.above += t.above;
        total.aboveSquared += t.aboveSquared;
    }
    const double all = double(total.photons);
    for (int c = 0; c < 3; ++c) {
        const double mean = total.above[c] / all;
        r.reflectance.value[c] = mean;
        r.reflectance.error[c] = std::sqrt(std::max(0.0, total.aboveSquared[c] / all - mean * mean) / (all - 1));
    }
    r.photons = total.photons;
    r.collisions = total.collisions;
    r.lost = total.lost;
    r.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return r;
}

} // namespace stf
