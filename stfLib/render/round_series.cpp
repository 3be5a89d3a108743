// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/round_series.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {
constexpr double kLargest = 0.99; ///< ratio
constexpr double kSteady = 0.05;  ///< relative change of the ratio from one round to the next
} // namespace

void RoundSeries::add(double change) {
    ++rounds_;
    ++plain_;
    steady_ = false;
    // The change after a leap is not of the series.
    if (plain_ >= 2 && change_ > 0) {
        const double ratio = std::min(kLargest, change / change_);
        steady_ = plain_ >= 3 && std::abs(ratio - ratio_) < kSteady * ratio_;
        ratio_ = ratio;
    }
    change_ = change;
}

bool RoundSeries::settled() const {
    const double ratio = std::max(ratio_, leapRatio_);
    return change_ * ratio / (1 - ratio) < enough_;
}

double RoundSeries::leap() {
    if (!steady_ || settled()) {
        return 0;
    }
    plain_ = 0;
    steady_ = false;
    leapRatio_ = ratio_;
    return ratio_ / (1 - ratio_);
}

} // namespace stf
