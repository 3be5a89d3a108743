// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/base/vec.h"

#include <string>
#include <vector>

namespace stf {

/// A latitude-longitude image of radiance, row 0 at the top (the pole +y).
struct LatLongImage {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;
    bool empty() const { return pixels.empty(); }
    const Rgb& at(int x, int y) const { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

/// Reads .exr (OpenEXR), .hdr, .png, .jpg and others (stb_image; 8-bit images are taken as sRGB and made linear).
/// Not finite or negative pixels become zero. Throws Error with the path.
LatLongImage readLatLong(const std::string& path);

} // namespace stf
