// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"
#include "stfLib/volume/samples.h"

#include "stfLib/base/random.h"

#include <cmath>

namespace stf {

namespace {

// Absorption in 1/mm. No measured table of jade is published; modelled so that a deep piece has the reflectance of
// gem jadeite photographed on grey (about 0.1, 0.35, 0.15), and pale clouds that of white jade.
const Vec3d kGreen{0.115, 0.020, 0.082}, kDeep{0.42, 0.110, 0.34}, kPale{0.0100, 0.0052, 0.0100};
const Vec3d kRust{0.05, 0.26, 0.75}, kGrain{1.1, 0.8, 1.0};
constexpr double kExtinction = 1.9; // 1/mm, with g = 0
constexpr double kIor = 1.66;       // jadeite

std::vector<Ball> grains(const BaseVolume& v, std::uint32_t seed) {
    CounterRng rng(seed, 77);
    const Vec3d extent = v.extentMm();
    std::vector<Ball> result(14);
    for (Ball& b : result) {
        b.middle =
            Vec3d(double(rng.uniform()) * extent.x, double(rng.uniform()) * extent.y, double(rng.uniform()) * extent.z);
        b.radius = extent.x * (0.006 + 0.012 * double(rng.uniform()));
    }
    return result;
}

} // namespace

BaseVolume makeJade(const SampleOptions& options) {
    BaseVolume v = blankSample("jade", options, {96, 96, 24}, 0.25);
    const TileNoise noise(v, options.seed);
    const std::vector<Ball> dark = grains(v, options.seed);
    const Vec3d extent = v.extentMm();
    v.ior.assign(v.voxelCount(), float(kIor));
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        // Warping twice draws the clouds out into the felted wisps of jade.
        const double w = 0.13 * extent.x;
        const Vec3d p = mm + Vec3d(noise(mm, 2, 1), noise(mm, 2, 2), noise(mm, 2, 3)) * w;
        const Vec3d q = p + Vec3d(noise(p, 4, 4), noise(p, 4, 5), noise(p, 4, 6)) * (0.5 * w);
        const double cloud = noise.fractal(q, 2, 4, 10);
        const double fibre = noise.fractal(q, 8, 3, 20);
        const double pale = smoothStep(0.02, 0.62, cloud + 0.18 * fibre);
        const double deep = smoothStep(-0.10, -0.62, cloud - 0.22 * fibre);
        // A healed crack, its stain running out on both sides where the stone lets it.
        const double crack = std::abs(double(noise(q, 2, 30)) + 0.06 * fibre);
        const double open = smoothStep(0.05, 0.45, double(noise(mm, 2, 31)));
        const double rust = open * (0.75 * std::exp(-std::pow(crack / 0.035, 2)) + 0.22 * smoothStep(0.22, 0.0, crack));
        const double grain = smoothStep(-0.5 * v.voxelMm.x, 0.5 * v.voxelMm.x, depthInBalls(dark, q, extent));
        Vec3d sigmaA = kGreen * ((1 - pale) * (1 - deep)) + kPale * pale + kDeep * (deep * (1 - pale));
        sigmaA += kRust * rust + kGrain * (0.8 * grain);
        setMedium(v, i, sigmaA, kExtinction, 1.0);
    });
    v.coreSigmaA = kGreen * 0.62 + kPale * 0.25 + kDeep * 0.10 + kRust * 0.03;
    v.coreSigmaSPrime = Vec3d(kExtinction) - v.coreSigmaA;
    return v;
}

} // namespace stf
