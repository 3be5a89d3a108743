// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// How samples of the image's plane are weighed into a pixel: a positive, separable filter that is sampled in
/// proportion to its value (Ernst, Stamminger and Greiner 2006, "Filter importance sampling", IEEE Symposium on
/// Interactive Ray Tracing). Every sample then counts the same and belongs to one pixel alone: pixels stay independent,
/// an image is the same for any order of tiles, and the variance of a pixel is that of its samples. Filters with
/// negative lobes (Mitchell, Lanczos) are no densities: with signed weights a pixel of even light would be noisy, or a
/// ratio of sums, and could turn negative beside a light; they are left out.
///
/// Immutable; used from all threads.
class PixelFilter {
public:
    enum class Shape {
        Box,
        Triangle,
        Gaussian,      ///< cut off at three standard deviations
        BlackmanHarris ///< the four-term window (Harris 1978)
    };

    /// `width`: of the whole support, pixels; 0: the shape's own (1, 2, 3, 3). Throws Error if negative or not finite.
    explicit PixelFilter(Shape shape = Shape::BlackmanHarris, float width = 0);

    /// Where a sample lies along one axis, pixels from the middle of its pixel; `u` in 0..1. Rises with u, so that
    /// well spread numbers give well spread samples.
    float offset(float u) const;
    /// The filter along one axis at `x` pixels from the middle; its integral is 1.
    float value(float x) const;
    float width() const { return width_; }

    /// Names as in the settings: box, triangle, gaussian, blackmanHarris. False for any other.
    static bool shapeFromName(const std::string& name, Shape& shape);

private:
    Shape shape_;
    float width_;
    std::vector<float> cumulative_; ///< of shapes without a closed inverse, over the support in equal steps
    /// For u in as many equal parts of 0..1: the first entry above the part's start, whence the search goes upward
    /// (Chen & Asau 1974, "On Generating Random Variates from an Empirical Distribution", the cutpoint method): less
    /// than two comparisons on average.
    std::vector<std::uint16_t> cutpoints_;
};

} // namespace stf
