// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/adaptive_sampling.h"

#include "stfLib/base/parallel.h"

#include <algorithm>

namespace stf {

namespace {
constexpr std::uint32_t kFirstPasses = 16;
constexpr double kLeastShare = 0.25; ///< of the image's mean luminance
} // namespace

void AdaptiveSampling::restart(int width, int height) {
    width_ = width;
    height_ = height;
    count_ = std::size_t(width) * std::size_t(height);
    active_.assign(count_, 1);
    judged_ = 0;
}

void AdaptiveSampling::beforePass(const Film& film, std::uint32_t pass, double target) {
    // After 16, 24, 36 ... passes: half as many again, so that judging costs next to nothing.
    if (!(target > 0) || pass < kFirstPasses || (judged_ > 0 && pass < judged_ + judged_ / 2) || pass == judged_) {
        return;
    }
    judged_ = pass;
    const std::vector<LuminanceEstimate> pixels = film.luminances();
    double mean = 0;
    for (const LuminanceEstimate& p : pixels) {
        mean += p.mean;
    }
    mean /= std::max<double>(1, double(pixels.size()));
    parallelFor(std::size_t(height_), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const int y = int(row);
            for (int x = 0; x < width_; ++x) {
                double error = 0, bright = 0;
                int n = 0;
                for (int j = std::max(0, y - 1); j <= std::min(height_ - 1, y + 1); ++j) {
                    for (int i = std::max(0, x - 1); i <= std::min(width_ - 1, x + 1); ++i, ++n) {
                        const LuminanceEstimate& p = pixels[std::size_t(j) * std::size_t(width_) + std::size_t(i)];
                        error += p.error;
                        bright += p.mean;
                    }
                }
                active_[row * std::size_t(width_) + std::size_t(x)] =
                    error / n > target * std::max(bright / n, kLeastShare * mean);
            }
        }
    });
    count_ = std::size_t(std::count(active_.begin(), active_.end(), std::uint8_t(1)));
}

} // namespace stf
