// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/tile_walks.h"

#include "stfLib/base/parallel.h"
#include "stfLib/transport/tile_tracer.h"

namespace stf {

namespace {

// A lookup near a surface interpolates with voxels that hold nothing: they take the mean of their neighbours.
void extendIntoVoids(const BaseVolume& volume, const std::vector<float>& fill, std::vector<float>& values,
                     int components) {
    if (fill.empty()) {
        return;
    }
    const Vec3i& s = volume.size;
    const std::size_t n = std::size_t(components);
    const std::vector<float> source = values;
    for (int z = 0; z < s.z; ++z) {
        for (int y = 0; y < s.y; ++y) {
            for (int x = 0; x < s.x; ++x) {
                const std::size_t i = volume.index(x, y, z);
                if (fill[i] > kLeastFill) {
                    continue;
                }
                float weight = 0;
                std::vector<float> sum(n, 0.0f);
                for (int c = 0; c < 27; ++c) {
                    const int nz = z + c / 9 - 1;
                    if (nz < 0 || nz >= s.z) {
                        continue;
                    }
                    const std::size_t j = volume.index(TileTracer::wrap(x + c % 3 - 1, s.x),
                                                       TileTracer::wrap(y + c / 3 % 3 - 1, s.y), nz);
                    for (std::size_t k = 0; k < n; ++k) {
                        sum[k] += fill[j] * source[j * n + k];
                    }
                    weight += fill[j];
                }
                for (std::size_t k = 0; k < n && weight > kLeastFill; ++k) {
                    values[i * n + k] = sum[k] / weight;
                }
            }
        }
    }
}

} // namespace

TileWalks::TileWalks(const BaseVolume& baseVolume, const TransportOptions& transportOptions, Progress& progress)
    : volume(baseVolume), options(transportOptions), medium(volume, options.form, options.openBottom),
      columns(std::size_t(volume.size.x) * std::size_t(volume.size.y)),
      walks(medium, options.seed, medium.wantsFlux(), columns == 1 || volume.voxelCount() < 20000 ? 8 : 4, progress),
      tileArea(volume.voxelMm.x * volume.voxelMm.y * double(columns)),
      pilotPhotons(columns == 1 ? 2400 : std::clamp<std::uint64_t>(columns * 8, 16000, 65536)) {
    if (medium.hasSurface()) {
        for (std::size_t i = 0; i < medium.voxelCount(); ++i) {
            fill.push_back(medium.fill(i));
        }
    }
}

void TileWalks::mean(std::vector<float>& field, const std::vector<GroupResult>& r, std::vector<float> GroupResult::*of,
                     float factor, float before, float now, int first, int last) const {
    last = last > first ? last : walks.groups();
    field.resize((r[0].*of).size());
    const float scale = factor * now / float(last - first);
    parallelFor(field.size(), std::size_t(1) << 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            float sum = 0;
            for (int g = first; g < last; ++g) {
                sum += (r[std::size_t(g)].*of)[i];
            }
            field[i] = field[i] * before + sum * scale;
        }
    });
}

void TileWalks::finish(std::vector<float>& field, int components) const {
    filter.apply(field, components, fill);
    extendIntoVoids(volume, fill, field, components);
}

} // namespace stf
