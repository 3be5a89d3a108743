// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/random.h"
#include "stfLib/base/vec.h"

namespace stf {

/// Low-discrepancy numbers of one pixel sample: a (0,2) Sobol sequence per pair of dimensions, Owen-scrambled by a
/// hash (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)) and shuffled per pair, so that pairs are
/// independent. Every prefix of samples is well stratified: an image may stop after any pass.
/// Deterministic by (seed, pixel, sample). Not shared between threads.
class PixelSampler {
public:
    PixelSampler(std::uint64_t seed, std::uint64_t pixel, std::uint32_t sample)
        : seed_(seed), pixel_(pixel), sample_(sample) {}

    /// `count` points of one pair of dimensions (a power of two keeps the stratification): together, the points of
    /// all samples of a pixel are one sequence.
    class Points {
    public:
        Vec2f operator[](int k) const;

    private:
        friend class PixelSampler;
        std::uint32_t first = 0, shuffle = 0, scrambleX = 0, scrambleY = 0;
    };
    Points next2dPoints(int count);
    /// In place of points that nothing reads: the next ones stay what they are. Gives zeros.
    Points skip2dPoints() {
        ++pair_;
        return {};
    }
    Vec2f next2d() { return next2dPoints(1)[0]; }
    float next1d() { return next2d().x; }

private:
    std::uint64_t seed_;
    std::uint64_t pixel_;
    std::uint32_t sample_;
    std::uint32_t pair_ = 0;
};

} // namespace stf
