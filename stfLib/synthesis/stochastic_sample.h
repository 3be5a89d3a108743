// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <string>

namespace stf {

/// Whether a sample is random enough to be blended with itself.
struct Randomness {
    bool stochastic = false;
    double excessKurtosis = 0; ///< the largest of any band, by absolute value
    std::string why;           ///< half a sentence
};

/// A texture that histogram-preserving blending keeps is a Gaussian random field, but for its histogram: made Gaussian
/// by rank, its responses to band-pass filters (differences of Gaussians, an octave apart) are normal then. Veins,
/// cells and edges leave heavier tails, regular patterns lighter ones (Field 1987, "Relations between the statistics of
/// natural images and the response properties of cortical cells", J. Opt. Soc. Am. A 4). Judged by the excess kurtosis
/// of reflectance and of extinction of columns, in bands with at least a hundred independent places; its own scatter
/// sqrt(24 / places) is allowed for. A sample with a relief is not: its surface cannot be blended.
Randomness judgeRandomness(const BaseVolume& volume);

} // namespace stf
