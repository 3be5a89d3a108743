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
    const auto aroundPixel = [&](int x, int y, const auto& visit) {
        for (int j = std::max(0, y - 1); j <= std::min(height_ - 1, y + 1); ++j) {
            for (int i = std::max(0, x - 1); i <= std::min(width_ - 1, x + 1); ++i) {
                visit(std::size_t(j) * std::size_t(width_) + std::size_t(i));
            }
        }
    };
    const auto everyPixel = [&](const auto& visit) {
        parallelFor(std::size_t(height_), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                for (int x = 0; x < width_; ++x) {
                    visit(x, int(row), row * std::size_t(width_) + std::size_t(x));
                }
            }
        });
    };
    // Which pixel around each that is not good enough has the largest error.
    constexpr std::uint32_t none = ~std::uint32_t(0);
    std::vector<std::uint32_t> worst(pixels.size(), none);
    everyPixel([&](int x, int y, std::size_t pixel) {
        double error = 0, bright = 0;
        int n = 0;
        std::size_t largest = pixel;
        aroundPixel(x, y, [&](std::size_t other) {
            const LuminanceEstimate& p = pixels[other];
            error += p.error;
            bright += p.mean;
            largest = p.error > pixels[largest].error ? other : largest;
            ++n;
        });
        if (error / n > target * std::max(bright / n, kLeastShare * mean)) {
            worst[pixel] = std::uint32_t(largest);
        }
    });
    everyPixel([&](int x, int y, std::size_t pixel) {
        bool active = worst[pixel] != none;
        aroundPixel(x, y, [&](std::size_t other) { active = active || worst[other] == pixel; });
        active_[pixel] = active;
    });
    count_ = std::size_t(std::count(active_.begin(), active_.end(), std::uint8_t(1)));
}

} // namespace stf
