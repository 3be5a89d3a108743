// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// An image as its file holds it, red, green, blue and alpha a pixel (alpha 1 where there is none, grey in all three),
/// row 0 at the top. One of `bytes` and `floats` is filled.
struct ImageFile {
    int width = 0, height = 0;
    int channels = 0;                ///< of the file
    std::vector<std::uint8_t> bytes; ///< 8 bits a channel, encoded as in the file
    std::vector<float> floats;       ///< of files with more than 8 bits, as they are; 16-bit numbers as 0 to 1
};

/// Reads .exr (OpenEXR) and .hdr, .png, .jpg, .tga, .bmp and others (stb_image). Throws Error with the path and a
/// reason, also where the image would take more than a gigabyte.
ImageFile readImageFile(const std::string& path);

} // namespace stf
