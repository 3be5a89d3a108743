// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/transfer_function.h"

#include "stfLib/base/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace stf {

namespace {

TransferFunction::Point pure(double value, std::size_t material, std::size_t materials) {
    TransferFunction::Point p{value, std::vector<double>(materials, 0.0)};
    p.fractions[material] = 1;
    return p;
}

} // namespace

TransferFunction::TransferFunction(std::vector<Point> points) : points_(std::move(points)) {
    if (points_.empty() || points_[0].fractions.empty()) {
        throw Error("a transfer function without points");
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const std::string which = "point " + std::to_string(i + 1) + " of the transfer function";
        double sum = 0;
        for (double f : points_[i].fractions) {
            if (!(f >= 0 && f <= 1 + 1e-6)) {
                throw Error(which + " has a fraction of " + std::to_string(f));
            }
            sum += f;
        }
        if (std::abs(sum - 1) > 1e-6) {
            throw Error("the fractions of " + which + " add up to " + std::to_string(sum) + ", not 1");
        }
        if (points_[i].fractions.size() != materials()) {
            throw Error(which + " has " + std::to_string(points_[i].fractions.size()) + " fractions, the first " +
                        std::to_string(materials()));
        }
        // Two points of one value are a step.
        if (!std::isfinite(points_[i].value) || (i > 0 && points_[i].value < points_[i - 1].value)) {
            throw Error(which + " is at " + std::to_string(points_[i].value) + ", before the one that it follows");
        }
    }
}

void TransferFunction::evaluate(double value, double* fractions) const {
    std::size_t next = 0;
    while (next < points_.size() && points_[next].value <= value) {
        ++next;
    }
    const Point& b = points_[std::min(next, points_.size() - 1)];
    const Point& a = points_[next == 0 ? 0 : next - 1];
    const double t = b.value > a.value ? (value - a.value) / (b.value - a.value) : 0;
    for (std::size_t m = 0; m < materials(); ++m) {
        fractions[m] = a.fractions[m] + t * (b.fractions[m] - a.fractions[m]);
    }
}

TransferFunction rampsAt(const std::vector<double>& thresholds, const std::vector<double>& widths) {
    if (thresholds.empty() || (widths.size() != thresholds.size() && widths.size() > 1)) {
        throw Error(std::to_string(thresholds.size()) + " thresholds with " + std::to_string(widths.size()) +
                    " widths");
    }
    const std::size_t materials = thresholds.size() + 1;
    std::vector<TransferFunction::Point> points;
    for (std::size_t i = 0; i < thresholds.size(); ++i) {
        const double w = widths.empty() ? 0 : widths[widths.size() == 1 ? 0 : i];
        const double lo = thresholds[i] - w / 2, hi = thresholds[i] + w / 2;
        if (!(w >= 0) || !std::isfinite(lo) || !std::isfinite(hi)) {
            throw Error("threshold " + std::to_string(thresholds[i]) + " has a width of " + std::to_string(w));
        }
        if (!points.empty() && lo < points.back().value) {
            throw Error("the ramps at thresholds " + std::to_string(thresholds[i - 1]) + " and " +
                        std::to_string(thresholds[i]) + " overlap or do not rise");
        }
        points.push_back(pure(lo, i, materials));
        points.push_back(pure(hi, i + 1, materials));
    }
    return TransferFunction(std::move(points));
}

TransferFunction rampsBetween(const std::vector<ValueClass>& classes) {
    if (classes.size() < 2) {
        throw Error("a classification takes two classes at least");
    }
    std::vector<double> thresholds, widths;
    for (std::size_t c = 0; c + 1 < classes.size(); ++c) {
        const ValueClass &a = classes[c], &b = classes[c + 1];
        const double gap = b.mean - a.mean;
        // Symmetric about the middle: what a cut through a voxel loses on one side it wins on the other.
        const double half = std::min(gap / 2 - 2 * a.sigma, gap / 2 - 2 * b.sigma);
        thresholds.push_back((a.mean + b.mean) / 2);
        widths.push_back(2 * std::max(half, gap / 8));
    }
    return rampsAt(thresholds, widths);
}

} // namespace stf
