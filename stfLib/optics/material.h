// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <string>

namespace stf {

/// A homogeneous medium as artists name it: coefficients per colour channel in 1/mm, one Henyey-Greenstein mean cosine
/// and one index of refraction. "none" (nothing scatters, nothing absorbs, index 1) is a void.
struct Material {
    std::string name;
    Vec3d sigmaA{0, 0, 0}; ///< absorption coefficient, 1/mm
    Vec3d sigmaS{0, 0, 0}; ///< scattering coefficient, 1/mm
    double g = 0;          ///< mean cosine, -1 < g < 1
    double ior = 1;        ///< relative to outside
    std::string source;    ///< where the numbers are from

    Vec3d extinction() const { return sigmaA + sigmaS; }
    Vec3d sigmaSPrime() const { return sigmaS * (1 - g); }
    bool isVoid() const { return maxComponent(sigmaA) == 0 && maxComponent(sigmaS) == 0; }
};

} // namespace stf
