// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"
#include "stfLib/volume/samples.h"

#include "stfLib/base/random.h"

#include <cmath>

namespace stf {

namespace {

// Absorption of pure ice at 610, 550 and 465 nm (Warren & Brandt 2008, "Optical constants of ice from the ultraviolet
// to the microwave", J. Geophys. Res. 113), 1/mm.
const Vec3d kIce{1.4e-4, 5.2e-5, 8e-6};
constexpr double kIor = 1.31;
// Bubbles scatter as spheres: sigma_s = 1.5 f / r for a share f of air in bubbles of radius r, and g = 0.86 (Mullen &
// Warren 1988, "Theory of the optical properties of lake ice", J. Geophys. Res. 93); here as sigma_s' with g = 0.
// Clear ice: f = 0.1 %, r = 0.5 mm. Bands of white ice: f = 5 %, r = 0.3 mm.
double reducedScattering(double airShare, double radiusMm) {
    return 1.5 * airShare / radiusMm * (1 - 0.86);
}

std::vector<Ball> bubbles(const BaseVolume& v, std::uint32_t seed) {
    CounterRng rng(seed, 99);
    const Vec3d extent = v.extentMm();
    std::vector<Ball> result;
    // Strings of bubbles that rose while the water froze: each from a place of its own, leaning a little.
    for (int string = 0; string < 26; ++string) {
        const Vec3d foot(double(rng.uniform()) * extent.x, double(rng.uniform()) * extent.y, 0);
        const double leanX = double(rng.uniform()) - 0.5, leanY = double(rng.uniform()) - 0.5;
        const int count = 3 + int(6 * rng.uniform());
        double z = double(rng.uniform()) * extent.z;
        for (int k = 0; k < count; ++k) {
            const double radius = extent.x * (0.006 + 0.015 * std::pow(double(rng.uniform()), 3));
            result.push_back({foot + Vec3d(leanX * z, leanY * z, z), radius});
            z = std::fmod(z + radius * (2.5 + 3 * double(rng.uniform())), extent.z);
        }
    }
    return result;
}

} // namespace

BaseVolume makeIce(const SampleOptions& options) {
    BaseVolume v = blankSample("ice", options, {96, 96, 30}, 2.5);
    const TileNoise noise(v, options.seed);
    const std::vector<Ball> air = bubbles(v, options.seed);
    const Vec3d extent = v.extentMm();
    v.ior.assign(v.voxelCount(), float(kIor));
    const double clear = reducedScattering(1e-3, 0.5), white = reducedScattering(0.05, 0.3),
                 bubble = reducedScattering(0.5, 0.3), crackWhite = reducedScattering(0.3, 0.2);
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        const double w = 0.10 * extent.x;
        const Vec3d p = mm + Vec3d(noise(mm, 2, 1), noise(mm, 2, 2), noise(mm, 2, 3)) * w;
        // Bands of the glacier's flow, drawn out along x; cracks, sharp and thin, with feathers beside them.
        const Vec3d drawn(p.x, p.y, 1.6 * p.z);
        const double band =
            smoothStep(0.16, 0.62, std::abs(double(noise(drawn, 2, 10))) + 0.16 * noise.fractal(p, 8, 3, 11));
        const double crack = std::abs(double(noise(p, 2, 20)) + 0.035 * double(noise(mm, 16, 21)));
        const double feather = std::max(0.0, double(noise(p, 16, 22)) + 0.25);
        const double cracked = smoothStep(-0.1, 0.3, double(noise(mm, 2, 23)));
        const double inside = smoothStep(-0.5 * v.voxelMm.x, 0.5 * v.voxelMm.x, depthInBalls(air, mm, extent));
        const double crackShare =
            cracked * (std::exp(-std::pow(crack / 0.020, 2)) + 0.35 * feather * smoothStep(0.12, 0.0, crack));
        // Water that freezes from outside drives its air inward: the heart of a piece is white.
        const double heart = smoothStep(0.6, 1.2, mm.z / extent.z + 0.20 * noise.fractal(p, 4, 3, 30));
        const double scattering =
            clear + white * (0.45 * band + 1.5 * heart) + crackWhite * crackShare + bubble * inside;
        const double extinction = scattering + average(kIce);
        v.extinction[i] = Rgb(float(extinction));
        v.albedo[i] = Rgb(Vec3d(1.0) - kIce / extinction);
    });
    v.coreSigmaA = kIce;
    v.coreSigmaSPrime = Vec3d(clear + 1.5 * white);
    return v;
}

} // namespace stf
