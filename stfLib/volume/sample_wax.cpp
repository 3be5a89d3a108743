// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"
#include "stfLib/volume/samples.h"

#include <cmath>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;

// Height of the wax above the valleys, 0..1: a rosette on a lattice, unchanged by every symmetry of the square.
double waxHeight(double u, double w) {
    const double cu = std::cos(2 * kPi * u), cw = std::cos(2 * kPi * w);
    const double dome = smoothStep(-0.75, 1.25, cu + cw);
    const double ring = std::exp(-std::pow((cu + cw - 0.55) / 0.22, 2));
    const double stud = smoothStep(1.15, 1.8, -(cu + cw));
    return std::clamp((0.55 * dome + 0.30 * ring + 0.65 * stud) / 0.70, 0.0, 1.0); // its highest point is 0.70
}

} // namespace

BaseVolume makeWax(const SampleOptions& options) {
    BaseVolume v = blankSample("wax", options, {64, 64, 32}, 10.0 / 64);
    const double extinction = 2.0;
    const Vec3d sigmaA{0.0035, 0.017, 0.085};
    const Vec3d extent = v.extentMm();
    const double relief = std::min(1.6, 0.4 * extent.z);
    v.surface.resize(v.voxelCount());
    // Depth of the wax surface below the tile's top; the highest point touches the top.
    const auto depthAt = [&](double x, double y) { return relief * (1 - waxHeight(x / extent.x, y / extent.y)); };
    const Relief surface(v, depthAt);
    forEachVoxel(v, [&](std::size_t i, const Vec3d& mm) {
        v.surface[i] = float(surface.distance(i, mm.z));
        // Coefficients are those of the wax: the surface says where it is. Voxels that it may cut have them, too.
        setMedium(v, i, sigmaA, extinction, double(v.surface[i]) > v.voxelMm.x ? 0.0 : 1.0);
    });
    v.coreSigmaA = sigmaA;
    v.coreSigmaSPrime = Vec3d(extinction) - sigmaA;
    return v;
}

} // namespace stf
