// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/synthesize.h"

namespace stf {

/// How good a synthesis is, by measures that an eye cares for (docs/synthesis.md). Distances are in appearance space,
/// in steps of CIE lightness.
struct SynthesisQuality {
    std::size_t samples = 0;
    double texelsPerSample = 0;    ///< area of the surface in texels over the number of samples
    double neighbourhoodError = 0; ///< rms distance of what surrounds a sample to what surrounds its texel
    double exemplarError = 0; ///< rms distance of a texel's neighbourhood to the most alike elsewhere in the sample
    double seamRate = 0;      ///< share of links across which coordinates jump by more than a texel
    double seamError = 0;     ///< rms distance across those links
    double reuseMax = 0;      ///< most used texel over the mean, by area
    double reuseEntropy = 0;  ///< of the use of texels, over that of equal use
    double ks = 0;            ///< largest Kolmogorov-Smirnov distance of a parameter's distribution, by area
    std::vector<std::pair<std::string, double>> ksOf;
    std::size_t foldOvers =
        0; ///< triangles whose coordinates are mirrored, but for slivers narrower than their rounding
    double deltaR =
        0; ///< mean reflectance of the columns shown over that of the sample, less 1, of the channel where it is most
    double deltaRSeams = 0;     ///< rms change of reflectance by light that crosses seams (seam_light.h)
    double stretch = 0;         ///< rms of the logarithm of the coordinates' two stretches
    double autocorrelation = 0; ///< largest difference of the radial autocorrelation of reflectance to the sample's
    std::size_t patches = 0;    ///< connected regions without a jump
    double patchMedian = 0, patchLargest = 0; ///< their areas in texels; the median by area
    std::size_t singularities = 0;
    int indexSum = 0;
};

SynthesisQuality measure(const Synthesis& synthesis, const ExemplarMap& map);

/// Number of the patch of every vertex, patches numbered by their first vertex.
std::vector<int> patchNumbers(const Synthesis& synthesis, int& count);

/// Largest distance between the cumulative distributions of two weighted samples; reorders them. Weights are positive.
double kolmogorovSmirnov(std::vector<std::pair<float, double>>& a, std::vector<std::pair<float, double>>& b);

} // namespace stf
