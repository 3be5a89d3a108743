// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"
#include "stfLib/volume/samples.h"

#include "stfLib/base/random.h"

#include <cmath>

namespace stf {

namespace {

// The skeleton is aragonite, whose sigma_s' is a few to ten per mm (Marcelino et al. 2013, "Modulation of
// light-enhancement to symbiotic algae by light-scattering in corals and evolutionary trends in bleaching", PLoS ONE
// 8); pigment modelled.
const Vec3d kPale{0.010, 0.034, 0.062}, kPigment{0.030, 0.42, 0.62};
constexpr double kExtinction = 3; // 1/mm, with g = 0

// Holes of many sizes, the large ones first and apart from each other, near the surface and below it.
std::vector<Ball> holes(const Vec3d& extent, double top, std::uint32_t seed) {
    CounterRng rng(seed, 55);
    std::vector<Ball> result;
    const auto place = [&](int count, double smallest, double largest, double apart) {
        for (int trial = 0; count > 0 && trial < 4000; ++trial) {
            Ball b;
            b.radius = extent.x * (smallest + (largest - smallest) * double(rng.uniform()));
            const double depth = double(rng.uniform());
            b.middle = {double(rng.uniform()) * extent.x, double(rng.uniform()) * extent.y,
                        top + depth * depth * (extent.z - top - b.radius)};
            if (depthInBalls(result, b.middle, extent) < -apart * b.radius) {
                result.push_back(b);
                --count;
            }
        }
    };
    place(34, 0.060, 0.085, 0.93);
    place(60, 0.032, 0.050, 0.95);
    place(160, 0.014, 0.026, 1.1);
    return result;
}

} // namespace

BaseVolume makeCoral(const SampleOptions& options) {
    BaseVolume v = blankSample("coral", options, {54, 54, 20}, 8.0 / 27);
    const TileNoise noise(v, options.seed);
    const Vec3d extent = v.extentMm();
    const double top = std::min(0.35, 0.1 * extent.z);
    const std::vector<Ball> voids = holes(extent, top, options.seed);
    v.surface.resize(v.voxelCount());
    const auto depthAt = [&](double x, double y) { return top * (1 - 0.8 * noise.fractal(Vec3d(x, y, 0), 4, 3, 1)); };
    const Relief crust(v, depthAt);
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        const double outside = crust.distance(i, mm.z);
        // The union of what lies above the top and of the holes.
        v.surface[i] = float(std::max(outside, depthInBalls(voids, mm, extent)));
        // Pigment where the living layer was: near the outer surface, least on the crests between holes.
        const double shade = std::clamp(0.5 + 0.7 * noise.fractal(mm, 2, 4, 10), 0.0, 1.0);
        const double living = smoothStep(3.2, 0.2, mm.z - top);
        const Vec3d sigmaA = kPale + kPigment * (0.10 + 0.55 * shade * living);
        setMedium(v, i, sigmaA, kExtinction, double(v.surface[i]) > v.voxelMm.x ? 0.0 : 1.0);
    });
    v.coreSigmaA = kPale + kPigment * 0.10;
    v.coreSigmaSPrime = Vec3d(kExtinction) - v.coreSigmaA;
    return v;
}

} // namespace stf
