// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/sampler.h"

namespace stf {

namespace {

std::uint32_t reverseBits(std::uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

// Burley 2020, section 3: Laine-Karras style permutation with the constants of its improved version.
std::uint32_t laineKarras(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

std::uint32_t owenScramble(std::uint32_t x, std::uint32_t seed) {
    return reverseBits(laineKarras(reverseBits(x), seed));
}

// Second dimension of the Sobol sequence, bits reversed; the first is the bit reversal of the index. Its matrix is
// Pascal's triangle modulo 2, which is made of copies of its own halves (Ahmed 2024, "An Implementation Algorithm of 2D
// Sobol Sequence Fast, Elegant, and Compact").
std::uint32_t sobolSecondReversed(std::uint32_t index) {
    index ^= index >> 16;
    index ^= (index & 0xff00ff00u) >> 8;
    index ^= (index & 0xf0f0f0f0u) >> 4;
    index ^= (index & 0xccccccccu) >> 2;
    index ^= (index & 0xaaaaaaaau) >> 1;
    return index;
}

float toUnit(std::uint32_t x) {
    return float(x >> 8) * 0x1p-24f;
}

} // namespace

PixelSampler::Points PixelSampler::next2dPoints(int count) {
    CounterRng rng(seed_ ^ (std::uint64_t(pair_++) << 32), pixel_);
    Points p;
    p.first = sample_ * std::uint32_t(count);
    p.shuffle = rng.bits();
    p.scrambleX = rng.bits();
    p.scrambleY = rng.bits();
    return p;
}

Vec2f PixelSampler::Points::operator[](int k) const {
    const std::uint32_t index = owenScramble(first + std::uint32_t(k), shuffle);
    // Two reversals one after the other are none.
    return {toUnit(reverseBits(laineKarras(index, scrambleX))),
            toUnit(reverseBits(laineKarras(sobolSecondReversed(index), scrambleY)))};
}

} // namespace stf
