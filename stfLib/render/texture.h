// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/image_file.h"
#include "stfLib/render/preview_surface.h"

#include <map>
#include <memory>
#include <mutex>

namespace stf {

/// An image on a surface, read with bilinear interpolation. Immutable, shared by threads.
class Texture {
public:
    using Rgba = TextureMap::Rgba;

    explicit Texture(ImageFile image) : image_(std::move(image)) {}

    /// Linear red, green, blue and alpha at texture coordinates: (0, 0) is the image's lower left, (1, 1) its upper
    /// right. Only the wrap modes and the colour space of `map` count. What is not finite is zero.
    Rgba at(Vec2f uv, const TextureMap& map) const;
    std::size_t bytes() const { return image_.bytes.size() + image_.floats.size() * sizeof(float); }

private:
    Rgba pixel(int x, int y, bool srgb) const;
    ImageFile image_;
};

/// Textures by path: materials that name the same file share it, as long as one of them holds it. A file that changed
/// on disk is read anew. Thread-safe.
class TextureStore {
public:
    /// Throws Error with the path.
    std::shared_ptr<const Texture> get(const std::string& path);

private:
    struct Entry {
        std::weak_ptr<const Texture> texture;
        long long changed = 0; ///< time of the file's last change
    };
    std::mutex mutex_;
    std::map<std::string, Entry> entries_;
};

} // namespace stf
