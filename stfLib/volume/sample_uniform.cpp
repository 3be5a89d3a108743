// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/sample_parts.h"
#include "stfLib/volume/samples.h"

#include "stfLib/base/random.h"

#include <cmath>

namespace stf {

namespace {

// A core like the volume's mean.
void setCore(BaseVolume& v, const Rgb& extinction, const SampleOptions& options) {
    const Vec3d kappa(extinction), albedo(options.albedo);
    v.coreSigmaA = kappa * (Vec3d(1.0) - albedo);
    v.coreSigmaSPrime = kappa * albedo * (1.0 - double(options.g));
}

} // namespace

BaseVolume makeUniform(const SampleOptions& options) {
    BaseVolume v = blankSample("uniform", options, {1, 1, 32}, 0.25);
    std::fill(v.extinction.begin(), v.extinction.end(), options.extinction);
    std::fill(v.albedo.begin(), v.albedo.end(), options.albedo);
    if (options.g != 0) {
        v.g.assign(v.voxelCount(), options.g);
    }
    setCore(v, options.extinction, options);
    return v;
}

BaseVolume makeRandom(const SampleOptions& options) {
    if (!(options.ratio >= 1 && options.ratio <= 1e12) || !(options.tau >= 0 && options.tau <= 1e6)) {
        throw Error("a random sample takes a ratio of 1 to 1e12 and a mean optical depth of 0 to 1e6");
    }
    BaseVolume v = blankSample("random", options, {64, 64, 32}, 1);
    CounterRng rng(options.seed, 0);
    double sum = 0;
    std::vector<double> kappa(v.voxelCount());
    for (double& k : kappa) {
        k = std::exp(double(rng.uniform()) * std::log(options.ratio));
        sum += k;
    }
    const double mean = options.tau / v.extentMm().z, scale = mean * double(v.voxelCount()) / sum;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        v.extinction[i] = Rgb(float(kappa[i] * scale));
    }
    std::fill(v.albedo.begin(), v.albedo.end(), options.albedo);
    if (options.g != 0) {
        v.g.assign(v.voxelCount(), options.g);
    }
    setCore(v, Rgb(float(mean)), options);
    return v;
}

} // namespace stf
