// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace stfrecord {

/// One AOV as floats or integers, rows from the top down, `channels` values a pixel.
struct Layer {
    std::string name; ///< in the image
    int channels = 0;
    std::vector<float> floats;
    std::vector<std::int32_t> integers; ///< used instead of `floats` where not empty
    /// The AOV, where it is not `name`: channels are called by what it is.
    std::string aov = {};
    bool half = false; ///< floats are written in half precision
    const std::string& kind() const { return aov.empty() ? name : aov; }
};

/// Pixels of a frame; may reach beyond it. Rows from the top down.
struct Window {
    int x = 0, y = 0, width = 0, height = 0;
};

struct Image {
    int width = 0, height = 0;
    /// Where the frame lies that this is a part of, in pixels of the image; empty: the image is the frame.
    Window frame;
    float pixelAspectRatio = 1; ///< width over height of a pixel
    std::vector<Layer> layers;
    std::vector<std::pair<std::string, std::string>> metadata;
};

/// Writes all layers into one EXR, the image as its data window, the frame as its display window: a layer `color` as R,
/// G, B, A, any other as LAYER.CHANNEL. The file appears when it is whole. Throws std::runtime_error with a sentence.
void writeExr(const Image& image, const std::string& path);

/// Writes the colour as 8-bit sRGB, over black, clipped to 0..1. The file appears when it is whole. Throws likewise;
/// also if there is no layer `color`.
void writePng(const Image& image, const std::string& path);

/// Names of a layer's channels in an EXR, in their order in the pixels.
std::vector<std::string> channelNames(const Layer& layer);

} // namespace stfrecord
