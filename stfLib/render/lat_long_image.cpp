// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/lat_long_image.h"

#include "stfLib/base/srgb.h"
#include "stfLib/render/image_file.h"

namespace stf {

LatLongImage readLatLong(const std::string& path) {
    const ImageFile file = readImageFile(path);
    LatLongImage image{file.width, file.height, {}};
    image.pixels.resize(std::size_t(file.width) * std::size_t(file.height));
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const std::size_t at = 4 * i + std::size_t(c);
            const float v = file.bytes.empty() ? file.floats[at] : srgbToLinear(float(file.bytes[at]) / 255);
            image.pixels[i][c] = std::isfinite(v) && v > 0 ? v : 0.0f;
        }
    }
    return image;
}

} // namespace stf
