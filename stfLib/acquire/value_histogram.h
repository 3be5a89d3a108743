// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace stf {

/// Counts of values in equal bins from the smallest value to the largest.
struct ValueHistogram {
    double lo = 0, hi = 0; ///< outer edges of the first and last bin
    std::vector<double> counts;

    std::size_t bins() const { return counts.size(); }
    double width() const { return (hi - lo) / double(bins()); }
    double middle(std::size_t bin) const { return lo + (double(bin) + 0.5) * width(); }
    double total() const;
};

/// Whole numbers over less than `bins` steps get a bin each, so that no bin holds more of them than its neighbour.
/// Throws Error where all values are the same or some are not finite.
ValueHistogram histogramOf(const std::vector<float>& values, std::size_t bins = 2048);

/// A class of values: what a method found, in rising order.
struct ValueClass {
    double share = 0; ///< of all values
    double mean = 0, sigma = 0;
};

} // namespace stf
