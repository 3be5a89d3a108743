// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/value_histogram.h"

#include "stfLib/base/error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stf {

double ValueHistogram::total() const {
    return std::accumulate(counts.begin(), counts.end(), 0.0);
}

ValueHistogram histogramOf(const std::vector<float>& values, std::size_t bins) {
    float lo = values.empty() ? 0.0f : values[0], hi = lo;
    bool whole = true;
    for (float v : values) {
        if (!std::isfinite(v)) {
            throw Error("a histogram of values that are not finite");
        }
        lo = std::min(lo, v);
        hi = std::max(hi, v);
        whole = whole && v == std::floor(v);
    }
    if (!(hi > lo)) {
        throw Error("all values are " + std::to_string(lo) + ": there is nothing to tell materials by");
    }
    ValueHistogram h;
    h.lo = double(lo);
    h.hi = double(hi);
    if (whole) {
        // Bins of a whole number of steps, edges between steps.
        const double steps = h.hi - h.lo + 1, perBin = std::max(1.0, std::ceil(steps / double(bins)));
        bins = std::size_t(std::ceil(steps / perBin));
        h.lo -= 0.5;
        h.hi = h.lo + perBin * double(bins);
    }
    h.counts.assign(bins, 0.0);
    const double scale = double(bins) / (h.hi - h.lo);
    for (float v : values) {
        ++h.counts[std::min(bins - 1, std::size_t((double(v) - h.lo) * scale))];
    }
    return h;
}

} // namespace stf
