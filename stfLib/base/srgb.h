// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace stf {

/// The linear value of one encoded by sRGB's curve (IEC 61966-2-1), 0 to 1.
inline float srgbToLinear(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

} // namespace stf
