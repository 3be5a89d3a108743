// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/bufferReader.h"

#include "pxr/base/gf/half.h"
#include "pxr/imaging/hd/types.h"

#include <algorithm>
#include <cstring>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

namespace {

float component(HdFormat format, const unsigned char* pixel, std::size_t index) {
    switch (format) {
    case HdFormatUNorm8:
        return float(pixel[index]) / 255.0f;
    case HdFormatSNorm8:
        return std::max(-1.0f, float(static_cast<signed char>(pixel[index])) / 127.0f);
    case HdFormatFloat16: {
        GfHalf half;
        std::uint16_t bits = 0;
        std::memcpy(&bits, pixel + 2 * index, sizeof(bits));
        half.setBits(bits);
        return half;
    }
    case HdFormatFloat32: {
        float value = 0;
        std::memcpy(&value, pixel + 4 * index, sizeof(value));
        return value;
    }
    default:
        return 0;
    }
}

} // namespace

Layer readLayer(HdRenderBuffer& buffer, const std::string& name) {
    buffer.Resolve();
    const HdFormat componentFormat = HdGetComponentFormat(buffer.GetFormat());
    const std::size_t channels = HdGetComponentCount(buffer.GetFormat());
    const std::size_t stride = HdDataSizeOfFormat(buffer.GetFormat());
    const std::size_t width = buffer.GetWidth(), height = buffer.GetHeight();
    Layer layer;
    layer.name = layer.aov = name;
    layer.channels = int(channels);
    const bool whole = componentFormat == HdFormatInt32;
    if (whole) {
        layer.integers.resize(width * height * channels);
    } else {
        layer.floats.resize(width * height * channels);
    }
    const auto* pixels = static_cast<const unsigned char*>(buffer.Map());
    for (std::size_t y = 0; pixels && y < height; ++y) {
        const unsigned char* row = pixels + (height - 1 - y) * width * stride;
        if (whole) {
            std::memcpy(layer.integers.data() + y * width * channels, row, width * stride);
            continue;
        }
        for (std::size_t x = 0; x < width; ++x) {
            for (std::size_t c = 0; c < channels; ++c) {
                layer.floats[(y * width + x) * channels + c] = component(componentFormat, row + x * stride, c);
            }
        }
    }
    buffer.Unmap();
    return layer;
}

} // namespace stfrecord
