// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/image_file.h"

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfRgbaFile.h>

#include <cstdlib>
#include <filesystem>
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

constexpr double kMostBytes = 1 << 30; // of one decoded image

void checkSize(double width, double height, double bytesPerPixel) {
    if (!(width > 0) || !(height > 0)) {
        throw Error("the image has no pixels");
    }
    if (width * height * bytesPerPixel > kMostBytes) {
        throw Error("the image is larger than a gigabyte");
    }
}

ImageFile readExr(const std::string& path) {
    Imf::RgbaInputFile file(path.c_str());
    const Imath::Box2i box = file.dataWindow();
    const double wide = double(box.max.x) - box.min.x + 1, high = double(box.max.y) - box.min.y + 1;
    checkSize(wide, high, 4 * sizeof(float));
    const int w = int(wide), h = int(high);
    Imf::Array2D<Imf::Rgba> rows(h, w);
    file.setFrameBuffer(&rows[0][0] - box.min.x - std::ptrdiff_t(box.min.y) * w, 1, std::size_t(w));
    file.readPixels(box.min.y, box.max.y);
    ImageFile image;
    image.width = w;
    image.height = h;
    const bool grey = file.channels() == Imf::WRITE_Y, alpha = file.channels() & Imf::WRITE_A;
    image.channels = (grey ? 1 : 3) + (alpha ? 1 : 0);
    image.floats.reserve(std::size_t(w) * std::size_t(h) * 4);
    for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
            const Imf::Rgba& p = rows[y][x];
            for (const float c : {float(p.r), float(p.g), float(p.b), float(p.a)}) {
                image.floats.push_back(c);
            }
        }
    }
    return image;
}

template<class T>
std::unique_ptr<T, void (*)(void*)> owned(T* data) {
    if (!data) {
        throw Error(stbi_failure_reason());
    }
    return {data, std::free};
}

ImageFile readOther(const std::string& path) {
    ImageFile image;
    int& w = image.width;
    int& h = image.height;
    int& channels = image.channels;
    if (!std::filesystem::exists(path)) {
        throw Error("there is no such file");
    }
    if (!stbi_info(path.c_str(), &w, &h, &channels)) {
        throw Error(stbi_failure_reason());
    }
    const bool hdr = stbi_is_hdr(path.c_str()), wide = !hdr && stbi_is_16_bit(path.c_str());
    checkSize(w, h, hdr || wide ? 4.0 * sizeof(float) : 4.0);
    const std::size_t count = std::size_t(w) * std::size_t(h) * 4;
    if (hdr) {
        const auto data = owned(stbi_loadf(path.c_str(), &w, &h, &channels, 4));
        image.floats.assign(data.get(), data.get() + count);
    } else if (wide) {
        const auto data = owned(stbi_load_16(path.c_str(), &w, &h, &channels, 4));
        image.floats.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            image.floats[i] = float(data.get()[i]) / 65535;
        }
    } else {
        const auto data = owned(stbi_load(path.c_str(), &w, &h, &channels, 4));
        image.bytes.assign(data.get(), data.get() + count);
    }
    return image;
}

bool endsWith(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

} // namespace

ImageFile readImageFile(const std::string& path) {
    try {
        return endsWith(path, ".exr") || endsWith(path, ".EXR") ? readExr(path) : readOther(path);
    } catch (const std::exception& e) {
        throw Error(path + ": " + e.what());
    }
}

} // namespace stf
