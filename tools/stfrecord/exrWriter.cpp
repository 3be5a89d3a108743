// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/atomicFile.h"
#include "tools/stfrecord/image.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <stdexcept>

namespace stfrecord {

std::vector<std::string> channelNames(const Layer& layer) {
    if (layer.name == "color" && layer.channels >= 3) {
        return layer.channels == 3 ? std::vector<std::string>{"R", "G", "B"}
                                   : std::vector<std::string>{"R", "G", "B", "A"};
    }
    const bool isDepth = layer.kind() == "depth" || layer.kind() == "cameraDepth";
    const bool isVector = layer.kind() == "normal" || layer.kind() == "Neye" || layer.kind() == "position";
    std::vector<std::string> names;
    if (layer.kind() == "sampleCount") {
        names = {"count"};
    } else if (!layer.integers.empty() && layer.channels == 1) {
        names = {"id"};
    } else if (layer.channels == 1) {
        names = {isDepth ? "Z" : layer.kind() == "alpha" ? "A" : "Y"};
    } else {
        names = isVector ? std::vector<std::string>{"X", "Y", "Z", "W"} : std::vector<std::string>{"R", "G", "B", "A"};
        names.resize(static_cast<std::size_t>(layer.channels));
    }
    for (std::string& name : names) {
        name = layer.name + "." + name;
    }
    return names;
}

void writeExr(const Image& image, const std::string& path) {
    const Window frame = image.frame.width > 0 ? image.frame : Window{0, 0, image.width, image.height};
    // The frame starts at (0, 0), the image lies where it is in it.
    const Imath::Box2i display({0, 0}, {frame.width - 1, frame.height - 1});
    const Imath::Box2i data({-frame.x, -frame.y}, {image.width - 1 - frame.x, image.height - 1 - frame.y});
    Imf::Header header(display, data, image.pixelAspectRatio);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const auto& [key, value] : image.metadata) {
        header.insert(key, Imf::StringAttribute(value));
    }
    const auto largest = static_cast<float>(HALF_MAX);
    std::vector<std::vector<half>> halves; // of the layers that are written so
    for (const Layer& layer : image.layers) {
        halves.emplace_back();
        if (layer.half) {
            for (const float value : layer.floats) {
                // What is beyond its range would be infinite, which a finite light is not.
                halves.back().push_back(half(std::max(-largest, std::min(largest, value))));
            }
        }
    }
    Imf::FrameBuffer pixels;
    for (const Layer& layer : image.layers) {
        const bool integer = !layer.integers.empty();
        const std::vector<std::string> names = channelNames(layer);
        const std::size_t valueSize = integer ? sizeof(std::int32_t) : sizeof(float);
        const std::size_t pixelSize = valueSize * static_cast<std::size_t>(layer.channels);
        const char* base = integer ? reinterpret_cast<const char*>(layer.integers.data())
                                   : reinterpret_cast<const char*>(layer.floats.data());
        for (std::size_t c = 0; c < names.size(); ++c) {
            // Ids are stored as unsigned: -1, nothing hit, reads as 4294967295.
            const Imf::PixelType type = integer ? Imf::UINT : Imf::FLOAT;
            if (layer.half && !integer) {
                header.channels().insert(names[c], Imf::Channel(Imf::HALF));
                const std::vector<half>& values = halves[std::size_t(&layer - image.layers.data())];
                const auto* first = reinterpret_cast<const char*>(values.data());
                const std::size_t stride = sizeof(half) * static_cast<std::size_t>(layer.channels);
                pixels.insert(names[c], Imf::Slice::Make(Imf::HALF, const_cast<char*>(first) + c * sizeof(half), data,
                                                         stride, stride * static_cast<std::size_t>(image.width)));
                continue;
            }
            header.channels().insert(names[c], Imf::Channel(type));
            // OpenEXR takes a writable pointer for both directions and only reads through it here.
            pixels.insert(names[c], Imf::Slice::Make(type, const_cast<char*>(base) + c * valueSize, data, pixelSize,
                                                     pixelSize * static_cast<std::size_t>(image.width)));
        }
    }
    writeAtomically(path, [&](const std::string& temporary) {
        try {
            Imf::OutputFile file(temporary.c_str(), header);
            file.setFrameBuffer(pixels);
            file.writePixels(image.height);
        } catch (const std::exception& error) {
            throw std::runtime_error("cannot write " + path + ": " + error.what());
        }
    });
}

} // namespace stfrecord
