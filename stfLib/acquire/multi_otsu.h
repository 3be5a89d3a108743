// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/value_histogram.h"

namespace stf {

/// Thresholds that split a histogram into k classes of the least sum of squared deviations from their means (Otsu 1979,
/// "A threshold selection method from gray-level histograms"; several thresholds: Liao, Chen, Chung 2001), exactly, by
/// dynamic programming over its bins. k - 1 rising values, at edges of bins; between classes that are apart, in the
/// middle of the gap. Throws Error for k < 2 or fewer filled bins than classes.
std::vector<double> otsuThresholds(const ValueHistogram& histogram, int k);

/// Shares, means and standard deviations of the classes between thresholds.
std::vector<ValueClass> classesBetween(const ValueHistogram& histogram, const std::vector<double>& thresholds);

/// The same with medians for means and 1.4826 times the median deviation from them for standard deviations (those of a
/// Gaussian): voxels that two materials share, which lie between the classes, then do not count for either's value.
std::vector<ValueClass> medianClasses(const ValueHistogram& histogram, const std::vector<double>& thresholds);

} // namespace stf
