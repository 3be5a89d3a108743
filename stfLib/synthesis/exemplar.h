// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/volume/base_volume.h"

#include <array>
#include <vector>

namespace stf {

/// An image over the tile, periodic, of vectors that look alike where the sample looks alike: Euclidean distance is
/// perceived difference, about 1 per step of CIE lightness.
struct AppearanceImage {
    static constexpr int dims = 8;
    using Value = std::array<float, dims>;

    int width = 0, height = 0;
    std::vector<Value> texels; ///< x fastest

    /// Of the texel that holds a place in texels (texel centres at halves), modulo the tile.
    const Value& at(int x, int y) const;
    /// Bilinear; `x`, `y` in texels.
    Value sample(float x, float y) const;
};

float squaredDistance(const AppearanceImage::Value& a, const AppearanceImage::Value& b);

/// What synthesis knows of a base volume: appearance space, its Gaussian stack, which texels are alike, and the
/// parameters whose histograms must be kept.
struct Exemplar {
    int width = 0, height = 0;
    Vec2d texelMm;
    /// Level 0 is the sample itself; level l sees it through a Gaussian of 2^l / 2 texels, at full size (a stack, not a
    /// pyramid: Lefebvre & Hoppe 2005).
    std::vector<AppearanceImage> stack;
    double keptVariance = 1; ///< share of the variance that the 8 dimensions hold
    /// k texels alike each texel, nearest first: similar[k * texel + i]; fewer are padded with the texel itself.
    int similarCount = 0;
    std::vector<int> similar;
    /// The same in what a Gaussian of two texels leaves: alike in structure, not in detail.
    std::vector<int> similarCoarse;
    std::vector<Rgb> response; ///< reflectance per texel
    Vec3d diffusionMm;         ///< diffusion length of the mean coefficients, per channel; infinite without absorption
    /// Parameters per texel for histograms: mean log10 of extinction, mean albedo (green), height of the surface.
    std::vector<std::vector<float>> parameters;
    std::vector<std::string> parameterNames;
    /// Root mean square distance of a texel's neighbourhood (itself and the 8 around it) to that of the texel most
    /// alike that is not near: what a perfect copy from elsewhere in the sample would have.
    double ownError = 0;

    Vec2d tileMm() const { return {width * texelMm.x, height * texelMm.y}; }
    std::size_t texelCount() const { return std::size_t(width) * std::size_t(height); }
    int wrapX(int x) const;
    int wrapY(int y) const;
};

/// Appearance space after Lefebvre & Hoppe 2006, "Appearance-space texture synthesis": per column the scattering and
/// absorption of its layers on a logarithmic scale (in bands of depth, fading as light does), the height of its surface
/// and its response to light, over a Gaussian-weighted neighbourhood of 5 x 5 columns, projected to 8 dimensions by
/// principal components. `response`: reflectance per column where a transport table gave it; empty: two streams
/// (column_response.h).
Exemplar makeExemplar(const BaseVolume& volume, const std::vector<Rgb>& response, Progress& progress);

} // namespace stf
