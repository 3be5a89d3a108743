// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

/// Arithmetic without branches or calls, for loops that compilers turn into vector instructions (lane_walk.cpp). All
/// functions are inlined into their caller, so that they are compiled for its instruction set.
#define STF_LANE inline __attribute__((always_inline))

namespace stf::lane {

/// Four random numbers: Threefry4x32 with 12 rounds (Salmon et al. 2011, which passes BigCrush with them), the block
/// that Random123 gives for this counter and key. Philox, which single walks draw from, multiplies, for which vectors
/// have few instructions; this one adds, rotates and xors.
struct Block {
    std::uint32_t r[4];
};
STF_LANE std::uint32_t rotate(std::uint32_t v, int by) {
    return (v << by) | (v >> (32 - by));
}
STF_LANE Block threefry(std::uint32_t c0, std::uint32_t c1, std::uint32_t k0, std::uint32_t k1, std::uint32_t k2,
                        std::uint32_t k3) {
    const std::uint32_t key[5] = {k0, k1, k2, k3, 0x1BD11BDAu ^ k0 ^ k1 ^ k2 ^ k3};
    constexpr int kTurns[8][2] = {{10, 26}, {11, 21}, {13, 27}, {23, 5}, {6, 20}, {17, 11}, {25, 10}, {18, 20}};
    std::uint32_t a = c0 + k0, b = c1 + k1, c = k2, d = k3;
#pragma GCC unroll 12
    for (int round = 0; round < 12; ++round) {
        const int first = kTurns[round % 8][0], second = kTurns[round % 8][1];
        if (round % 2 == 0) {
            a += b, b = rotate(b, first) ^ a;
            c += d, d = rotate(d, second) ^ c;
        } else {
            a += d, d = rotate(d, first) ^ a;
            c += b, b = rotate(b, second) ^ c;
        }
        if (round % 4 == 3) {
            const int n = round / 4 + 1;
            a += key[n % 5], b += key[(n + 1) % 5], c += key[(n + 2) % 5], d += key[(n + 3) % 5] + std::uint32_t(n);
        }
    }
    return {{a, b, c, d}};
}

STF_LANE float fromBits(std::uint32_t bits) {
    float f;
    std::memcpy(&f, &bits, 4);
    return f;
}
STF_LANE std::uint32_t toBits(float f) {
    std::uint32_t bits;
    std::memcpy(&bits, &f, 4);
    return bits;
}

/// Uniform in [0, 1), 24 bits.
STF_LANE float uniform(std::uint32_t bits) {
    return float(std::int32_t(bits >> 8)) * 0x1p-24f;
}

/// Exponential with mean 1: -log((bits + 1/2) 2^-32), from 1e-10 to 23, relative error below 3e-7 everywhere: near 1
/// the argument's distance from 1 is formed exactly. Polynomial: logf of Cephes (Moshier 1989).
STF_LANE float exponential(std::uint32_t bits) {
    const bool nearOne = bits >= 0xB504F334u; // sqrt(1/2)
    // Conversions of signed numbers only: of unsigned ones not every instruction set has vectors.
    const float rest = float(std::int32_t(~bits)) + 0.5f; // < 2^31 where nearOne
    const float all = float(std::int32_t(bits >> 8)) * 256.0f + (float(std::int32_t(bits & 255u)) + 0.5f);
    const std::uint32_t word = toBits(all);
    const std::int32_t power = std::int32_t(word - 0x3F3504F3u) >> 23;
    const float mantissa = fromBits(word - (std::uint32_t(power) << 23));
    const float e = nearOne ? 0.0f : float(power - 32), x = nearOne ? rest * -0x1p-32f : mantissa - 1.0f;
    const float square = x * x;
    float y = 7.0376836292e-2f;
    y = y * x - 1.1514610310e-1f;
    y = y * x + 1.1676998740e-1f;
    y = y * x - 1.2420140846e-1f;
    y = y * x + 1.4249322787e-1f;
    y = y * x - 1.6668057665e-1f;
    y = y * x + 2.0000714765e-1f;
    y = y * x - 2.4999993993e-1f;
    y = y * x + 3.3333331174e-1f;
    y = y * x * square - 0.5f * square - 2.12194440e-4f * e;
    return -(x + y + 0.693359375f * e);
}

/// sin(2 pi t) for |t| <= 1/4: Taylor to the eleventh power, error below 1e-7.
STF_LANE float sineOfTurn(float t) {
    const float x = 6.28318531f * t, s = x * x;
    float y = -2.5052108e-8f;
    y = y * s + 2.7557319e-6f;
    y = y * s - 1.9841270e-4f;
    y = y * s + 8.3333333e-3f;
    y = y * s - 1.6666667e-1f;
    return x + x * s * y;
}
/// cos and sin of 2 pi u for u in [0, 1).
STF_LANE float cosine(float u) {
    return -sineOfTurn(0.25f - std::fabs(u - 0.5f));
}
STF_LANE float sine(float u) {
    const float v = 0.5f - u, a = std::fabs(v);
    return sineOfTurn(std::copysign(a > 0.25f ? 0.5f - a : a, v));
}

/// Cosine and sine of a scattering angle by Henyey & Greenstein, as sampleHenyeyGreenstein (optics/phase.h).
struct Angle {
    float cos, sin;
};
STF_LANE Angle scatterAngle(float g, float u) {
    const float a = std::fabs(g), m = 1.0f - a, d = 1.0f / (m + 2.0f * a * u);
    const float oneMinus = 2.0f * (m * d) * (m * d) * (1.0f - u) * (1.0f + a * u);
    const float onePlus = 2.0f * ((1.0f + a) * d) * ((1.0f + a) * d) * u * (m + a * u);
    const float product = oneMinus * onePlus;
    const float c = oneMinus < 1.0f ? 1.0f - oneMinus : onePlus - 1.0f;
    return {std::copysign(1.0f, g) * c, std::sqrt(product > 0.0f ? product : 0.0f)};
}

/// fresnelSplit (optics/fresnel.h) for eta != 1 and cosI > 0.
struct Split {
    double reflectance, cosT;
};
STF_LANE Split fresnel(double cosI, double eta) {
    const double c = cosI < 1.0 ? cosI : 1.0, wide = (eta - 1) * (eta + 1), square = wide + c * c;
    const double g = std::sqrt(square > 0.0 ? square : 0.0);
    const double a = wide / ((c + g) * (c + g)), q = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    const double r = 0.5 * a * a * (1.0 + q * q), t = g / eta;
    return {square > 0.0 && r < 1.0 ? r : 1.0, square > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0};
}

} // namespace stf::lane
