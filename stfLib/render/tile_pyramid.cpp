// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/tile_pyramid.h"

#include "stfLib/base/parallel.h"
#include "stfLib/render/tile_march.h"

#include <cmath>
#include <cstdio>

namespace stf {

namespace {

constexpr int kGroups = 16, kPathsPerGroup = 512;

// Lights and views that radiance is compared for: overhead and slant, with and against the light.
struct Setting {
    Vec3f light, viewer;
};
const Setting kSettings[] = {{{0, 0, 1}, {0.3f, 0, 0.9539f}},
                             {{0.8f, 0, 0.6f}, {0, 0, 1}},
                             {{0, 0.8f, 0.6f}, {0, 0.8f, 0.6f}},
                             {{-0.8f, 0, 0.6f}, {0.9165f, 0, 0.4f}}};

/// Mean radiance of the tile's top per group of paths, [group]. Paths of one group start at the same places at every
/// level and draw the same numbers, so that differences are less noisy than radiances.
std::vector<Rgb> meanRadiance(const TileMedium& medium, const StfTable& table, const Setting& s) {
    std::vector<Rgb> means(kGroups, Rgb(0.0f));
    const Vec3f perMm{float(-s.viewer.x / medium.voxelMm().x), float(-s.viewer.y / medium.voxelMm().y),
                      float(s.viewer.z / medium.voxelMm().z)};
    const MarchLight light{s.light, Rgb(1.0f), Rgb(1.0f)};
    const float length = float(medium.voxelMm().z * medium.size().z) / s.viewer.z;
    parallelFor(kGroups, 1, [&](std::size_t begin, std::size_t end) {
        TileMarch march(medium, table);
        for (std::size_t g = begin; g < end; ++g) {
            Vec3d sum(0.0);
            for (int i = 0; i < kPathsPerGroup; ++i) {
                PixelSampler sampler(7, g, std::uint32_t(i));
                const Vec2f at = sampler.next2d();
                march.begin(sampler);
                march.setFrame(&light, 1, s.viewer);
                march.segment({at.x * float(medium.size().x), at.y * float(medium.size().y), 0}, perMm, length);
                const TileRadiance r = march.finish();
                sum += Vec3d(r.single + r.multiple);
            }
            means[g] = Rgb(sum / double(kPathsPerGroup));
        }
    });
    return means;
}

/// Mean square of the relative difference of means over settings and channels, less what the scatter of the groups
/// explains; not below 0.
double squaredError(const std::vector<std::vector<Rgb>>& fine, const std::vector<std::vector<Rgb>>& coarse) {
    double sum = 0;
    int count = 0;
    for (std::size_t s = 0; s < fine.size(); ++s) {
        for (int c = 0; c < 3; ++c) {
            double mean = 0, difference = 0, squares = 0;
            for (std::size_t g = 0; g < kGroups; ++g) {
                const double d = double(coarse[s][g][c]) - double(fine[s][g][c]);
                mean += double(fine[s][g][c]) / kGroups;
                difference += d / kGroups;
                squares += d * d / kGroups;
            }
            if (mean > 0) {
                const double noise = (squares - difference * difference) / (kGroups - 1);
                sum += (difference * difference - noise) / (mean * mean);
                ++count;
            }
        }
    }
    return count ? std::max(0.0, sum / count) : 0.0;
}

} // namespace

TilePyramid::TilePyramid(const BaseVolume& volume, std::shared_ptr<const TileMedium> medium,
                         std::shared_ptr<const StfTable> table)
    : voxelMm_(float(std::max(volume.voxelMm.x, volume.voxelMm.y))) {
    levels_.emplace_back();
    levels_[0].medium = std::move(medium);
    levels_[0].table = std::move(table);
}

TilePyramid::TilePyramid(const BaseVolume& volume, std::shared_ptr<const TileMedium> medium,
                         std::shared_ptr<const StfTable> table, bool backlight, double tolerance)
    : TilePyramid(volume, medium, table) {
    std::vector<std::vector<Rgb>> fine;
    for (int factor = 2;; factor *= 2) {
        if (!canCoarsen(volume, *medium, factor)) {
            why_ = medium->hasSurface()        ? "a relief has no coarser levels"
                   : volume.laterallyUniform() ? "the sample is the same everywhere"
                                               : "no fewer columns";
            return;
        }
        Level level;
        static_cast<CoarseTile&>(level) = coarsenTile(volume, *medium, *table, factor, backlight);
        std::vector<std::vector<Rgb>> coarse;
        for (const Setting& s : kSettings) {
            if (factor == 2) {
                fine.push_back(meanRadiance(*medium, *table, s));
            }
            coarse.push_back(meanRadiance(*level.medium, *level.table, s));
        }
        level.error = std::sqrt(squaredError(fine, coarse));
        if (level.error > tolerance) {
            char text[120];
            std::snprintf(text, sizeof text, "columns made fewer by %d would change its radiance by %.2g %%", factor,
                          100 * level.error);
            why_ = text;
            return;
        }
        levels_.push_back(std::move(level));
    }
}

int TilePyramid::levelFor(float footprintMm, float u) const {
    if (levels_.size() < 2 || !(footprintMm > 2 * voxelMm_)) {
        return 0;
    }
    // Not NaN here; the cast is safe below the number of levels.
    const float wanted = std::min(std::log2(0.5f * footprintMm / voxelMm_), float(levels_.size() - 1));
    const float whole = std::floor(wanted);
    return std::min(int(whole) + (u < wanted - whole ? 1 : 0), int(levels_.size()) - 1);
}

std::size_t TilePyramid::bytes() const {
    std::size_t sum = 0;
    for (std::size_t l = 1; l < levels_.size(); ++l) {
        sum += levels_[l].table->bytes() + levels_[l].medium->voxelCount() * sizeof(TileMedium::Voxel);
    }
    return sum;
}

} // namespace stf
