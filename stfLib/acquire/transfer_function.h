// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/value_histogram.h"

#include <cstddef>
#include <vector>

namespace stf {

/// Percentage classification by value (Drebin, Carpenter, Hanrahan 1988, "Volume rendering"; Kaufman 1991): what share
/// of a voxel each material fills, linear between control points and constant beyond the first and last.
class TransferFunction {
public:
    struct Point {
        double value = 0;
        std::vector<double> fractions; ///< of each material, >= 0, of sum 1
    };
    /// Throws Error: no points, values that do not rise, fractions that are negative or do not add up to 1 (within
    /// 1e-6), points of different lengths.
    explicit TransferFunction(std::vector<Point> points);

    std::size_t materials() const { return points_.front().fractions.size(); }
    const std::vector<Point>& points() const { return points_; }
    /// Writes materials() fractions.
    void evaluate(double value, double* fractions) const;

private:
    std::vector<Point> points_;
};

/// Steps at thresholds, smeared to ramps of these widths around them: neighbouring materials share a voxel within.
/// Throws Error where thresholds do not rise, widths are negative or ramps overlap.
TransferFunction rampsAt(const std::vector<double>& thresholds, const std::vector<double>& widths);

/// Ramps about the middle between the values of neighbouring classes, as partial volumes of two pure materials have
/// them: what lies within two standard deviations (the larger of both) of a mean counts as pure, but a ramp takes at
/// least a quarter of the way between means.
TransferFunction rampsBetween(const std::vector<ValueClass>& classes);

} // namespace stf
