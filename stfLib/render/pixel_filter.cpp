// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/pixel_filter.h"

#include "stfLib/base/error.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kSteps = 1024;      // of the cumulative distribution: a step is 1/300 of a pixel at the usual widths
constexpr double kDeviations = 3; // of the Gaussian within half its support

float ownWidth(PixelFilter::Shape shape) {
    switch (shape) {
    case PixelFilter::Shape::Box:
        return 1;
    case PixelFilter::Shape::Triangle:
        return 2;
    case PixelFilter::Shape::Gaussian:
    case PixelFilter::Shape::BlackmanHarris:
        break;
    }
    return 3;
}

// The share of the filter below `x`, -1..1 over the support.
double cumulativeAt(PixelFilter::Shape shape, double x) {
    if (shape == PixelFilter::Shape::Gaussian) {
        const auto below = [](double deviations) { return 0.5 * std::erfc(-deviations / std::sqrt(2.0)); };
        const double cut = below(-kDeviations);
        return (below(kDeviations * x) - cut) / (1 - 2 * cut);
    }
    // The window's integral; its mean is the first coefficient.
    const double t = kPi * (x + 1), a[4] = {0.35875, 0.48829, 0.14128, 0.01168};
    return (a[0] * t - a[1] * std::sin(t) + a[2] / 2 * std::sin(2 * t) - a[3] / 3 * std::sin(3 * t)) / (2 * kPi * a[0]);
}

} // namespace

PixelFilter::PixelFilter(Shape shape, float width) : shape_(shape), width_(width == 0 ? ownWidth(shape) : width) {
    if (!(width_ > 0) || !std::isfinite(width_)) {
        throw Error("the pixel filter's width is not a positive number");
    }
    if (shape == Shape::Gaussian || shape == Shape::BlackmanHarris) {
        cumulative_.resize(kSteps + 1);
        for (int i = 0; i <= kSteps; ++i) {
            cumulative_[std::size_t(i)] = float(cumulativeAt(shape, 2.0 * i / kSteps - 1));
        }
        cumulative_.front() = 0;
        cumulative_.back() = 1;
        cutpoints_.resize(kSteps);
        for (int k = 0; k < kSteps; ++k) {
            const auto above =
                std::upper_bound(cumulative_.begin() + 1, cumulative_.end() - 1, float(k) / float(kSteps));
            cutpoints_[std::size_t(k)] = std::uint16_t(above - cumulative_.begin());
        }
    }
}

float PixelFilter::offset(float u) const {
    u = std::clamp(u, 0.0f, 1.0f);
    if (shape_ == Shape::Box) {
        return (u - 0.5f) * width_;
    }
    if (shape_ == Shape::Triangle) {
        return (u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 - 2 * u)) * 0.5f * width_;
    }
    // The step whose share holds u, evenly filled.
    std::size_t above = cutpoints_[std::size_t(std::min(int(u * float(kSteps)), kSteps - 1))];
    while (above < std::size_t(kSteps) && cumulative_[above] <= u) {
        ++above;
    }
    const float low = cumulative_[above - 1], share = cumulative_[above] - low;
    const float step = float(above - 1) + (share > 0 ? (u - low) / share : 0.5f);
    return (step / kSteps - 0.5f) * width_;
}

float PixelFilter::value(float x) const {
    const float t = 2 * std::abs(x) / width_; // 0..1 over the support
    if (t >= 1) {
        return 0;
    }
    switch (shape_) {
    case Shape::Box:
        return 1 / width_;
    case Shape::Triangle:
        return (1 - t) * 2 / width_;
    case Shape::Gaussian: {
        const double deviation = 0.5 * double(width_) / kDeviations, d = double(x) / deviation;
        return float(std::exp(-0.5 * d * d) /
                     (deviation * std::sqrt(2 * kPi) * std::erf(kDeviations / std::sqrt(2.0))));
    }
    case Shape::BlackmanHarris:
        break;
    }
    const double w = kPi * double(1 - t), a[4] = {0.35875, 0.48829, 0.14128, 0.01168};
    return float((a[0] - a[1] * std::cos(w) + a[2] * std::cos(2 * w) - a[3] * std::cos(3 * w)) /
                 (a[0] * double(width_)));
}

bool PixelFilter::shapeFromName(const std::string& name, Shape& shape) {
    const std::pair<const char*, Shape> names[] = {{"box", Shape::Box},
                                                   {"triangle", Shape::Triangle},
                                                   {"gaussian", Shape::Gaussian},
                                                   {"blackmanHarris", Shape::BlackmanHarris}};
    for (const auto& [known, value] : names) {
        if (name == known) {
            shape = value;
            return true;
        }
    }
    return false;
}

} // namespace stf
