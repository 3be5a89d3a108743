// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/map_stf.h"

#include "stfLib/base/parallel.h"
#include "stfLib/base/temporary_folder.h"
#include "stfLib/render/tile_march.h"
#include "stfLib/transport/precompute.h"
#include "tools/stf/map_walk.h"

#include <chrono>
#include <cmath>
#include <cstdio>

namespace stf {

namespace {

constexpr std::size_t kGrain = 16; // columns at a time

// Mean of the radiance over a column's top, along parallel lines of sight.
Measured marchColumn(TileMarch& march, const TileMedium& medium, const MapOptions& o, int column) {
    const Vec3f& v = o.towardsViewer;
    const Vec3f mm(medium.voxelMm());
    const Vec3f perMm{-v.x / mm.x, -v.y / mm.y, v.z / mm.z};
    const float length = float(medium.size().z) * mm.z / v.z;
    const MarchLight light{o.towardsLight, Rgb(1.0f), Rgb(1.0f)};
    const float x = float(column % medium.size().x), y = float(column / medium.size().x);
    Measured m;
    Vec3d squares{0, 0, 0};
    for (int s = 0; s < o.samples; ++s) {
        PixelSampler sampler(o.seed, std::uint64_t(column), std::uint32_t(s));
        const Vec2f at = sampler.next2d();
        march.begin(sampler, {0, 0});
        march.setFrame(&light, 1, v);
        march.segment({x + at.x, y + at.y, 0}, perMm, length);
        const TileRadiance seen = march.finish();
        const Vec3d radiance(seen.single + seen.multiple);
        m.value += radiance;
        squares += radiance * radiance;
    }
    const double n = double(o.samples);
    for (int c = 0; c < 3; ++c) {
        m.value[c] /= n;
        m.error[c] = std::sqrt(std::max(0.0, squares[c] / n - m.value[c] * m.value[c]) / (n - 1));
    }
    return m;
}

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

MapResult mapByTable(const BaseVolume& volume, const MapOptions& o, Progress& progress) {
    const auto start = std::chrono::steady_clock::now();
    requireFlatTile(volume);
    const MessageSink messages = [](Severity, const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); };
    MapResult r;
    TransportOptions transport;
    transport.form = o.form;
    transport.quality = float(o.quality);
    transport.seed = o.seed;
    const TemporaryFolder folder;
    const std::string key = volume.contentHash() + ";" + transport.key();
    writeTable(precompute(volume, transport, progress, messages), key, folder.file("map_table.vdb"));
    const StfTable table = readTable(folder.file("map_table.vdb"), key);
    r.precomputeSeconds = secondsSince(start);
    r.tableError = table.error.total();
    r.photons = table.photons;
    r.collisions = table.collisions;

    const auto marching = std::chrono::steady_clock::now();
    const TileMedium medium(volume, o.form);
    r.width = volume.size.x;
    r.height = volume.size.y;
    r.columns.resize(std::size_t(r.width) * std::size_t(r.height));
    parallelFor(r.columns.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        TileMarch march(medium, table);
        for (std::size_t i = begin; i < end; ++i) {
            if (progress.cancelled()) {
                throw Cancelled();
            }
            r.columns[i] = marchColumn(march, medium, o, int(i));
        }
    });
    for (const Measured& m : r.columns) {
        r.mean.value += m.value;
        r.mean.error += m.error * m.error;
    }
    const double n = double(r.columns.size());
    r.mean.value = r.mean.value * (1 / n);
    for (int c = 0; c < 3; ++c) {
        r.mean.error[c] = std::sqrt(r.mean.error[c]) / n;
    }
    r.marchSeconds = secondsSince(marching);
    r.seconds = secondsSince(start);
    return r;
}

} // namespace stf
