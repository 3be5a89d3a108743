// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/value_histogram.h"

namespace stf {

/// A mixture of k Gaussians fitted to a histogram by expectation maximisation (Dempster, Laird, Rubin 1977), begun at
/// Otsu's classes, until the log-likelihood per value grows by less than 1e-9. No Gaussian becomes narrower than a
/// 200th of the range: a background of one exact value would take a class for itself and its rim. A uniform part
/// between the outermost means takes the voxels that materials share (Santago & Gage 1993, "Quantification of MR brain
/// images by mixture density and partial volume modeling"), which would pull means together; shares are those of the
/// rest. Rising means. Throws Error like otsuThresholds.
std::vector<ValueClass> fitGaussianMixture(const ValueHistogram& histogram, int k);

} // namespace stf
