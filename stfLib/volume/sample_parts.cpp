// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"

#include <cmath>

#define STB_PERLIN_IMPLEMENTATION
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_perlin.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace stf {

TileNoise::TileNoise(const BaseVolume& volume, std::uint32_t seed)
    : tileX_(volume.extentMm().x), tileY_(volume.extentMm().y), seed_(seed) {}

float TileNoise::operator()(const Vec3d& mm, int cells, std::uint32_t salt) const {
    const double f = cells / tileX_, fy = cells / tileY_;
    // The lattice repeats every `cells` in z too; an offset by the salt keeps octaves apart.
    return stb_perlin_noise3_seed(float(mm.x * f), float(mm.y * fy), float(mm.z * f), cells, cells, 0,
                                  int((seed_ * 7919u + salt * 104729u) & 0xff));
}

double TileNoise::fractal(const Vec3d& mm, int cells, int octaves, std::uint32_t salt) const {
    double sum = 0, height = 1;
    for (int i = 0; i < octaves; ++i, cells *= 2, height *= 0.5) {
        sum += height * double((*this)(mm, cells, salt + std::uint32_t(i)));
    }
    return sum;
}

double depthInBalls(const std::vector<Ball>& balls, const Vec3d& mm, const Vec3d& extentMm) {
    double deepest = -1e30;
    for (const Ball& b : balls) {
        // The nearest of the ball's copies.
        const double dx = mm.x - b.middle.x, dy = mm.y - b.middle.y;
        const double x = dx - extentMm.x * std::floor(dx / extentMm.x + 0.5);
        const double y = dy - extentMm.y * std::floor(dy / extentMm.y + 0.5);
        deepest = std::max(deepest, b.radius - length(Vec3d(x, y, mm.z - b.middle.z)));
    }
    return deepest;
}

double smoothStep(double lo, double hi, double x) {
    const double t = std::clamp((x - lo) / (hi - lo), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

BaseVolume blankSample(const char* name, const SampleOptions& options, const Vec3i& size, double voxelMm) {
    BaseVolume v;
    v.name = name;
    v.size = options.size == Vec3i(0, 0, 0) ? size : options.size;
    v.voxelMm = Vec3d(options.voxelMm > 0 ? options.voxelMm : voxelMm);
    const double n = double(v.size.x) * double(v.size.y) * double(v.size.z);
    if (minComponent(v.size) < 1 || n > double(kMaxVoxels)) {
        throw Error("sample size is not usable (1 to " + std::to_string(kMaxVoxels) + " voxels)");
    }
    v.extinction.resize(v.voxelCount());
    v.albedo.resize(v.voxelCount());
    return v;
}

void setMedium(BaseVolume& v, std::size_t i, const Vec3d& sigmaA, double extinction, double coverage) {
    v.extinction[i] = Rgb(float(extinction * coverage));
    v.albedo[i] = Rgb(Vec3d(1.0) - sigmaA / extinction);
}

} // namespace stf
