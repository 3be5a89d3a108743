// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/texture.h"

#include "stfLib/base/srgb.h"

#include <cmath>
#include <filesystem>

namespace stf {

namespace {

const std::array<float, 256>& srgbTable() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t{};
        for (std::size_t i = 0; i < t.size(); ++i) {
            t[i] = srgbToLinear(float(i) / 255);
        }
        return t;
    }();
    return table;
}

// Of a pixel's number anywhere, that in the image; -1: there is none.
int wrapped(long long i, int n, TextureMap::Wrap wrap) {
    switch (wrap) {
    case TextureMap::Wrap::Repeat:
        return int(((i % n) + n) % n);
    case TextureMap::Wrap::Mirror: {
        const long long m = ((i % (2LL * n)) + 2LL * n) % (2LL * n);
        return int(m < n ? m : 2LL * n - 1 - m);
    }
    case TextureMap::Wrap::Clamp:
        return int(std::min<long long>(std::max<long long>(i, 0), n - 1));
    default:
        return i >= 0 && i < n ? int(i) : -1;
    }
}

} // namespace

Texture::Rgba Texture::pixel(int x, int y, bool srgb) const {
    if (x < 0 || y < 0) {
        return {0, 0, 0, 0};
    }
    const std::size_t i = 4 * (std::size_t(y) * std::size_t(image_.width) + std::size_t(x));
    Rgba p;
    for (std::size_t c = 0; c < 4; ++c) {
        if (image_.bytes.empty()) {
            const float v = image_.floats[i + c];
            p[c] = !std::isfinite(v) ? 0.0f : srgb && c < 3 ? srgbToLinear(v) : v;
        } else {
            p[c] = srgb && c < 3 ? srgbTable()[image_.bytes[i + c]] : float(image_.bytes[i + c]) / 255;
        }
    }
    return p;
}

Texture::Rgba Texture::at(Vec2f uv, const TextureMap& map) const {
    using ColorSpace = TextureMap::ColorSpace;
    const bool srgb = map.colorSpace == ColorSpace::Srgb ||
                      (map.colorSpace == ColorSpace::Auto && !image_.bytes.empty() && image_.channels >= 3);
    const double fx = double(uv.x) * image_.width - 0.5, fy = (1 - double(uv.y)) * image_.height - 0.5;
    if (!(std::abs(fx) < 1e15) || !(std::abs(fy) < 1e15)) {
        return {0, 0, 0, 0};
    }
    const double x0 = std::floor(fx), y0 = std::floor(fy);
    const float ax = float(fx - x0), ay = float(fy - y0);
    Rgba sum{0, 0, 0, 0};
    for (int k = 0; k < 4; ++k) {
        const int dx = k & 1, dy = k >> 1;
        const float weight = (dx ? ax : 1 - ax) * (dy ? ay : 1 - ay);
        const Rgba p = pixel(wrapped((long long)x0 + dx, image_.width, map.wrapS),
                             wrapped((long long)y0 + dy, image_.height, map.wrapT), srgb);
        for (std::size_t c = 0; c < 4; ++c) {
            sum[c] += weight * p[c];
        }
    }
    return sum;
}

std::shared_ptr<const Texture> TextureStore::get(const std::string& path) {
    std::error_code error;
    const auto time = std::filesystem::last_write_time(path, error);
    const long long changed = error ? 0 : (long long)time.time_since_epoch().count();
    const std::lock_guard<std::mutex> lock(mutex_);
    Entry& entry = entries_[path];
    std::shared_ptr<const Texture> texture = entry.texture.lock();
    if (!texture || entry.changed != changed) {
        texture = std::make_shared<const Texture>(readImageFile(path));
        entry = {texture, changed};
    }
    return texture;
}

} // namespace stf
