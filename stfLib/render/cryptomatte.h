// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

namespace stf {

// Ids of objects as Cryptomatte has them (Friedman and Jones, "Fully automatic id mattes with support for motion blur
// and transparency", 2015; Cryptomatte specification 1.2.0).

/// MurmurHash3_x86_32 (Appleby, public domain) of the bytes of a text.
inline std::uint32_t murmurHash3(const std::string& text, std::uint32_t seed = 0) {
    const auto rotateLeft = [](std::uint32_t x, int bits) { return (x << bits) | (x >> (32 - bits)); };
    const auto scramble = [&](std::uint32_t k) { return rotateLeft(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
    std::uint32_t h = seed;
    const auto byte = [&](std::size_t i) { return std::uint32_t(static_cast<unsigned char>(text[i])); };
    const std::size_t whole = text.size() / 4 * 4;
    for (std::size_t i = 0; i < whole; i += 4) {
        h ^= scramble(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
        h = rotateLeft(h, 13) * 5 + 0xe6546b64u;
    }
    std::uint32_t rest = 0;
    for (std::size_t i = text.size(); i > whole; --i) {
        rest = rest << 8 | byte(i - 1);
    }
    h ^= scramble(rest);
    h ^= std::uint32_t(text.size());
    h = (h ^ (h >> 16)) * 0x85ebca6bu;
    h = (h ^ (h >> 13)) * 0xc2b2ae35u;
    return h ^ (h >> 16);
}

/// The hash of a name, with a bit of its exponent turned where it would be a float that is denormal, infinite or no
/// number. Never 0, which is nothing.
inline std::uint32_t cryptomatteId(const std::string& name) {
    const std::uint32_t hash = murmurHash3(name), exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ (1u << 23) : hash;
}

/// The float of the same bits, as images hold it; 0 for 0.
inline float cryptomatteFloat(std::uint32_t id) {
    float value = 0;
    std::memcpy(&value, &id, sizeof(value));
    return value;
}

} // namespace stf
