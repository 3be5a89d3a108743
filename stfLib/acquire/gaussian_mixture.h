// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/value_histogram.h"

namespace stf {

/// A mixture of k Gaussians fitted to a histogram by expectation maximisation (Dempster, Laird, Rubin 1977), begun at
/// Otsu's classes, until the log-likelihood per value grows by less than 1e-9. No Gaussian becomes narrower than a bin.
/// Rising means. Throws Error like otsuThresholds.
std::vector<ValueClass> fitGaussianMixture(const ValueHistogram& histogram, int k);

} // namespace stf
