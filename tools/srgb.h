// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace stf {

/// A linear value as a byte of sRGB (IEC 61966-2-1); clamped to 0..1, NaN becomes 0.
inline unsigned char srgbByte(float linear) {
    const float x = linear > 0 ? std::min(linear, 1.0f) : 0.0f;
    const float y = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
    return static_cast<unsigned char>(std::lround(255 * y));
}

} // namespace stf
