// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/base/vec.h"

#include <cstdint>
#include <cstring>

namespace stf {

/// What is known at the middle of a voxel, as it is before packing.
struct ShellPoint {
    Vec2d exemplar;     ///< tile mm, any representative modulo the tile
    double depth = 0;   ///< mm below the limit surface
    Vec3d gradX, gradY; ///< tile mm per mm of the object
    Vec3d normal;       ///< unit
    std::uint32_t triangle = 0;
    float b1 = 0, b2 = 0; ///< barycentric
};

/// The same in 32 bytes, two samples in a cache line. Coordinates are fractions of the tile in 24 bits, so that
/// integers wrap as the tile does (16 bits would be off by a sixteenth of a texel in a tile of 4096); the depth is in
/// 16 bits of its range, gradients are halves, the normal an octahedral map in 2 x 16 bits (Meyer et al. 2010, "On
/// floating-point normal vectors").
struct alignas(32) ShellSample {
    std::int16_t gradient[6]; ///< of x, then of y, as halves without denormals
    std::int16_t octahedral[2];
    std::uint32_t x, y;     ///< upper 24 bits: fraction of the tile; lower 8: the depth's lower and upper byte
    std::uint32_t triangle; ///< of the surface
    std::uint16_t b1, b2;   ///< barycentric there, in 1/65535
};
static_assert(sizeof(ShellSample) == 32, "two samples share a cache line");

constexpr std::uint32_t kFractionBits = 0xffffff00u;

/// Packs and unpacks the samples of one level.
struct ShellCodec {
    Vec2d tileMm{1, 1};
    double depthLow = 0;  ///< mm, of the packed number 0
    double depthStep = 1; ///< mm per 1

    ShellSample pack(const ShellPoint& p) const;
    ShellPoint unpack(const ShellSample& s) const;
};

/// Half of a float, rounded to nearest; at most 65504; zero below 2^-14, so that nothing is denormal.
inline std::int16_t toHalf(float v) {
    constexpr float largest = 65504.0f, least = 0x1p-14f;
    const float magnitude = std::min(std::abs(v), largest);
    if (!(magnitude >= least)) {
        return 0;
    }
    std::uint32_t bits;
    std::memcpy(&bits, &magnitude, sizeof bits);
    bits += 0xfffu + (bits >> 13 & 1u);
    const std::uint32_t half = (bits >> 13) - (112u << 10);
    return std::int16_t(half | (std::signbit(v) ? 0x8000u : 0u));
}

/// The exponent of a half, moved to its place in a float, is 112 too low: a multiplication mends that.
inline float fromHalf(std::int16_t half) {
    const std::uint32_t bits = (std::uint32_t(std::int32_t(half)) << 13) & 0x8fffffffu;
    float v;
    std::memcpy(&v, &bits, sizeof v);
    return v * 0x1p112f;
}

} // namespace stf
