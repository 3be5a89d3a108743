// SPDX-License-Identifier: Apache-2.0
#include "tools/srgb.h"
#include "tools/stfrecord/atomicFile.h"
#include "tools/stfrecord/image.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image_write.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <stdexcept>

namespace stfrecord {
void writePng(const Image& image, const std::string& path) {
    const auto color = std::find_if(image.layers.begin(), image.layers.end(),
                                    [](const Layer& layer) { return layer.kind() == "color" && layer.channels >= 3; });
    if (color == image.layers.end() || color->floats.empty()) {
        throw std::runtime_error("cannot write " + path + ": the AOV \"color\" was not rendered");
    }
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    std::vector<unsigned char> bytes(3 * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            bytes[3 * i + c] = stf::srgbByte(color->floats[i * static_cast<std::size_t>(color->channels) + c]);
        }
    }
    writeAtomically(path, [&](const std::string& temporary) {
        if (!stbi_write_png(temporary.c_str(), image.width, image.height, 3, bytes.data(), 3 * image.width)) {
            throw std::runtime_error("cannot write " + path);
        }
    });
}

} // namespace stfrecord
