// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/lat_long_image.h"

#include <ImfArray.h>
#include <ImfRgbaFile.h>

#include <cstdlib>
#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wsign-compare"
#endif
#include <stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace stf {

namespace {

LatLongImage readExr(const std::string& path) {
    try {
        Imf::RgbaInputFile file(path.c_str());
        const Imath::Box2i box = file.dataWindow();
        const int w = box.max.x - box.min.x + 1, h = box.max.y - box.min.y + 1;
        Imf::Array2D<Imf::Rgba> rows(h, w);
        file.setFrameBuffer(&rows[0][0] - box.min.x - box.min.y * w, 1, std::size_t(w));
        file.readPixels(box.min.y, box.max.y);
        LatLongImage image{w, h, {}};
        image.pixels.reserve(std::size_t(w) * std::size_t(h));
        for (int y = 0; y < h; ++y) {
            for (int x = 0; x < w; ++x) {
                const Imf::Rgba& p = rows[y][x];
                image.pixels.emplace_back(float(p.r), float(p.g), float(p.b));
            }
        }
        return image;
    } catch (const std::exception& e) {
        throw Error(path + ": " + e.what());
    }
}

LatLongImage readOther(const std::string& path) {
    int w = 0, h = 0, channels = 0;
    // stb makes 8-bit images linear with gamma 2.2; the sRGB curve differs by less than a code value where it matters.
    const std::unique_ptr<float, void (*)(void*)> data(stbi_loadf(path.c_str(), &w, &h, &channels, 3), std::free);
    if (!data) {
        throw Error(path + ": " + stbi_failure_reason());
    }
    LatLongImage image{w, h, {}};
    for (std::size_t i = 0; i < std::size_t(w) * std::size_t(h); ++i) {
        image.pixels.emplace_back(data.get()[3 * i], data.get()[3 * i + 1], data.get()[3 * i + 2]);
    }
    return image;
}

} // namespace

LatLongImage readLatLong(const std::string& path) {
    const bool exr =
        path.size() > 4 && (path.substr(path.size() - 4) == ".exr" || path.substr(path.size() - 4) == ".EXR");
    LatLongImage image = exr ? readExr(path) : readOther(path);
    for (Rgb& p : image.pixels) {
        for (int c = 0; c < 3; ++c) {
            p[c] = std::isfinite(p[c]) && p[c] > 0 ? p[c] : 0.0f;
        }
    }
    return image;
}

} // namespace stf
