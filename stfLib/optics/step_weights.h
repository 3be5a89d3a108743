// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// Transmittance over a step of optical depth x, and the weight of a constant source in it.
struct StepWeights {
    float transmittance; ///< exp(-x)
    float phi1;          ///< (1 - exp(-x)) / x, 1 at x = 0; the source S over length h adds S h phi1
};

/// Weights of a march step (exponential integrators; Hochbruck & Ostermann 2010, "Exponential integrators", phi_1).
/// Never divides by the extinction: any x >= 0 up to infinity; relative error of both below 2e-7.
inline StepWeights stepWeights(float x) {
    if (x < 0.5f) {
        const float e = std::expm1(-x);
        return {1 + e, x > 1e-12f ? -e / x : 1.0f};
    }
    const float t = std::exp(-x);
    return {t, (1 - t) / x};
}

/// The same per channel.
struct StepWeightsRgb {
    Rgb transmittance, phi1;
};
inline StepWeightsRgb stepWeights(const Rgb& x) {
    const StepWeights r = stepWeights(x.x);
    if (x.x == x.y && x.y == x.z) { // grey extinction is the common case
        return {Rgb(r.transmittance), Rgb(r.phi1)};
    }
    const StepWeights g = stepWeights(x.y), b = stepWeights(x.z);
    return {{r.transmittance, g.transmittance, b.transmittance}, {r.phi1, g.phi1, b.phi1}};
}

} // namespace stf
