// SPDX-License-Identifier: Apache-2.0
#include "stfLib/shell/shell_sample.h"

namespace stf {

namespace {

constexpr double kOctahedralScale = 32767;

std::int16_t toOctahedral(double v) {
    return std::int16_t(std::lround(std::clamp(v, -1.0, 1.0) * kOctahedralScale));
}

/// Fraction of the tile in the upper 24 bits.
std::uint32_t toFraction(double mm, double tile) {
    const double turns = mm / tile;
    return std::uint32_t(std::int64_t(std::llround((turns - std::floor(turns)) * 0x1p24))) << 8;
}

} // namespace

ShellSample ShellCodec::pack(const ShellPoint& p) const {
    ShellSample s;
    for (int a = 0; a < 3; ++a) {
        s.gradient[a] = toHalf(float(p.gradX[a]));
        s.gradient[3 + a] = toHalf(float(p.gradY[a]));
    }
    const Vec3d& n = p.normal;
    const double scale = 1 / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    double ox = n.x * scale, oy = n.y * scale;
    if (n.z < 0) {
        const double fx = (1 - std::abs(oy)) * (ox >= 0 ? 1 : -1);
        oy = (1 - std::abs(ox)) * (oy >= 0 ? 1 : -1);
        ox = fx;
    }
    s.octahedral[0] = toOctahedral(ox);
    s.octahedral[1] = toOctahedral(oy);
    const auto depth = std::uint32_t(std::lround(std::clamp((p.depth - depthLow) / depthStep, 0.0, 65535.0)));
    s.x = toFraction(p.exemplar.x, tileMm.x) | (depth & 0xffu);
    s.y = toFraction(p.exemplar.y, tileMm.y) | depth >> 8;
    s.triangle = p.triangle;
    s.b1 = std::uint16_t(std::lround(p.b1 * 65535.0f));
    s.b2 = std::uint16_t(std::lround(p.b2 * 65535.0f));
    return s;
}

ShellPoint ShellCodec::unpack(const ShellSample& s) const {
    ShellPoint p;
    for (int a = 0; a < 3; ++a) {
        p.gradX[a] = double(fromHalf(s.gradient[a]));
        p.gradY[a] = double(fromHalf(s.gradient[3 + a]));
    }
    double x = s.octahedral[0] / kOctahedralScale, y = s.octahedral[1] / kOctahedralScale;
    const double z = 1 - std::abs(x) - std::abs(y), fold = std::max(-z, 0.0);
    x += x >= 0 ? -fold : fold;
    y += y >= 0 ? -fold : fold;
    p.normal = normalize(Vec3d(x, y, z));
    p.depth = depthLow + depthStep * double((s.x & 0xffu) | (s.y & 0xffu) << 8);
    p.exemplar = {double(s.x & kFractionBits) * 0x1p-32 * tileMm.x, double(s.y & kFractionBits) * 0x1p-32 * tileMm.y};
    p.triangle = s.triangle;
    p.b1 = float(s.b1) / 65535.0f;
    p.b2 = float(s.b2) / 65535.0f;
    return p;
}

} // namespace stf
