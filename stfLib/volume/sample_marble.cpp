// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"
#include "stfLib/volume/samples.h"

#include <cmath>

namespace stf {

BaseVolume makeMarble(const SampleOptions& options) {
    BaseVolume v = blankSample("marble", options, {96, 96, 20}, 0.4);
    // Reduced albedo of marble (Jensen et al. 2001) at the extinction of its green channel, taken with g = 0.
    const double extinction = 2.624;
    const Vec3d sigmaA{0.0025, 0.0041, 0.0062};
    // Veins: iron-stained calcite, absorbing a hundred times as much; stains run out of them.
    const Vec3d veinA{0.34, 0.46, 0.60}, stainA{0.014, 0.036, 0.085};
    const TileNoise noise(v, options.seed);
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        // Domain warping bends the veins; it is periodic since the noise is.
        const double w = 0.16 * v.extentMm().x;
        const Vec3d p = mm + Vec3d(noise(mm, 2, 1), noise(mm, 2, 2), noise(mm, 2, 3)) * w +
                        Vec3d(noise(mm, 8, 4), noise(mm, 8, 5), noise(mm, 8, 6)) * (0.14 * w);
        const double broad = std::abs(noise(p, 2, 7) + 0.08 * noise(p, 16, 11));
        const double fine = std::abs(noise(p, 4, 8) + 0.20 * noise(p, 16, 9));
        const double strength = smoothStep(-0.35, 0.30, noise(mm, 4, 10));
        double vein = (0.25 + 0.75 * strength) * std::exp(-std::pow(broad / 0.030, 2));
        vein += 0.5 * smoothStep(0.1, 0.7, 1 - strength) * std::exp(-std::pow(fine / 0.022, 2));
        vein = std::min(1.0, vein);
        const double stain = smoothStep(0.28, 0.0, broad) * (0.25 + 0.75 * strength);
        setMedium(v, i, sigmaA + stainA * stain + veinA * vein, extinction, 1.0);
    });
    v.coreSigmaA = sigmaA + stainA * 0.25 + veinA * 0.02;
    v.coreSigmaSPrime = Vec3d(extinction) - v.coreSigmaA;
    return v;
}

} // namespace stf
