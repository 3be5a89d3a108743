// SPDX-License-Identifier: Apache-2.0
#include "stfLib/volume/base_volume.h"

#include <xxhash.h>

#include <cstdio>
#include <memory>
#include <sstream>

namespace stf {

namespace {

std::string where(const BaseVolume& v, std::size_t i) {
    const std::size_t nx = std::size_t(v.size.x), ny = std::size_t(v.size.y);
    std::ostringstream s;
    s << "(" << i % nx << ", " << i / nx % ny << ", " << i / nx / ny << ")";
    return s.str();
}

template<class T, class Bad>
void check(const BaseVolume& v, const char* grid, const std::vector<T>& values, bool required, const char* rule,
           Bad bad) {
    if (values.empty() && !required) {
        return;
    }
    if (values.size() != v.voxelCount()) {
        std::ostringstream s;
        s << "grid '" << grid << "' has " << values.size() << " values, the tile has " << v.voxelCount() << " voxels";
        throw Error(s.str());
    }
    std::size_t count = 0, first = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (bad(values[i]) && count++ == 0) {
            first = i;
        }
    }
    if (count) {
        std::ostringstream s;
        s << "grid '" << grid << "' has " << count << " value(s) that are " << rule << ", the first at voxel "
          << where(v, first);
        throw Error(s.str());
    }
}

bool badRgb(const Rgb& c, float lo, float hi) {
    return !(isFinite(c) && minComponent(c) >= lo && maxComponent(c) <= hi);
}

std::string hexadecimal(const XXH128_hash_t& hash) {
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return text;
}

bool badCoefficients(const Vec3d& c) {
    return !isFinite(c) || minComponent(c) < 0;
}

} // namespace

void validate(const BaseVolume& v) {
    const double n = double(v.size.x) * double(v.size.y) * double(v.size.z);
    if (minComponent(v.size) < 1 || maxComponent(v.size) > (1 << 20) || n > double(kMaxVoxels)) {
        std::ostringstream s;
        s << "tile size " << v.size.x << " x " << v.size.y << " x " << v.size.z << " is not usable (1 to " << kMaxVoxels
          << " voxels)";
        throw Error(s.str());
    }
    if (!isFinite(v.voxelMm) || minComponent(v.voxelMm) <= 0) {
        throw Error("voxel size must be positive and finite");
    }
    check(v, "extinction", v.extinction, true, "negative, above 1e9 or not finite",
          [](const Rgb& c) { return badRgb(c, 0, 1e9f); });
    check(v, "albedo", v.albedo, true, "outside 0..1 or not finite", [](const Rgb& c) { return badRgb(c, 0, 1); });
    check(v, "g", v.g, false, "outside -1 < g < 1 or not finite", [](float x) { return !(x > -1 && x < 1); });
    check(v, "ior", v.ior, false, "outside 0.1..10 or not finite", [](float x) { return !(x >= 0.1f && x <= 10); });
    check(v, "surface", v.surface, false, "not finite", [](float x) { return !std::isfinite(x); });
    check(v, "emission", v.emission, false, "negative or not finite", [](const Rgb& c) { return badRgb(c, 0, 1e30f); });
    if (badCoefficients(v.coreSigmaA) || badCoefficients(v.coreSigmaSPrime)) {
        throw Error("core coefficients must be finite and not negative");
    }
}

BaseVolume cropDepth(const BaseVolume& volume, int layers) {
    BaseVolume v = volume;
    v.size.z = std::clamp(layers, 1, volume.size.z);
    const auto cut = [&](auto& values) {
        if (!values.empty()) {
            values.resize(v.voxelCount()); // z is the slowest index
        }
    };
    cut(v.extinction);
    cut(v.albedo);
    cut(v.g);
    cut(v.ior);
    cut(v.surface);
    cut(v.emission);
    return v;
}

BaseVolume subdivide(const BaseVolume& volume) {
    if (!volume.surface.empty()) {
        throw Error("a sample with a relief is not subdivided");
    }
    if (8 * volume.voxelCount() > kMaxVoxels) {
        throw Error("the sample is too large to be subdivided");
    }
    BaseVolume v = volume;
    v.size = {2 * volume.size.x, 2 * volume.size.y, 2 * volume.size.z};
    v.voxelMm = volume.voxelMm * 0.5;
    const auto cut = [&](auto& values) {
        if (values.empty()) {
            return;
        }
        const auto coarse = values;
        values.resize(v.voxelCount());
        for (int z = 0; z < v.size.z; ++z) {
            for (int y = 0; y < v.size.y; ++y) {
                for (int x = 0; x < v.size.x; ++x) {
                    values[v.index(x, y, z)] = coarse[volume.index(x / 2, y / 2, z / 2)];
                }
            }
        }
    };
    cut(v.extinction);
    cut(v.albedo);
    cut(v.g);
    cut(v.ior);
    cut(v.emission);
    return v;
}

bool BaseVolume::laterallyUniform() const {
    const std::size_t layer = std::size_t(size.x) * std::size_t(size.y);
    for (std::size_t i = 0; i < voxelCount(); ++i) {
        const std::size_t j = i / layer * layer;
        const auto differs = [&](const auto& values) { return !values.empty() && values[i] != values[j]; };
        if (differs(extinction) || differs(albedo) || differs(g) || differs(ior) || differs(surface) ||
            differs(emission)) {
            return false;
        }
    }
    return true;
}

bool BaseVolume::hasRelief() const {
    for (const Rgb& k : extinction) {
        if (maxComponent(k) == 0) {
            return true;
        }
    }
    for (float d : surface) {
        if (d > 0) {
            return true;
        }
    }
    return false;
}

std::string BaseVolume::contentHash() const {
    const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), XXH3_freeState);
    XXH3_128bits_reset(state.get());
    const auto add = [&](const auto& values) {
        const std::size_t count = values.size();
        XXH3_128bits_update(state.get(), &count, sizeof count);
        XXH3_128bits_update(state.get(), values.data(), count * sizeof values[0]);
    };
    XXH3_128bits_update(state.get(), &size, sizeof size);
    XXH3_128bits_update(state.get(), &voxelMm, sizeof voxelMm);
    add(extinction);
    add(albedo);
    add(g);
    add(ior);
    add(surface);
    add(emission);
    return hexadecimal(XXH3_128bits_digest(state.get()));
}

std::string contentHashOf(const std::string& text) {
    return hexadecimal(XXH3_128bits(text.data(), text.size()));
}

} // namespace stf
