// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/core/point_cells.h"

#include <cstdint>
#include <vector>

namespace stf {

/// Points of a surface that stand for parts of it.
struct SurfacePoints {
    std::vector<Vec3f> positions; ///< mm
    std::vector<Vec3f> normals;   ///< unit, outward; empty: all points are on one side
    std::vector<float> areas;     ///< mm^2
};

/// Means of values at samples around other places of the same surface: weights fall smoothly to zero at a radius, count
/// by the samples' areas and by how much the normals agree, and sum to 1 at each place. Where no sample is that near,
/// the nearest is taken. Immutable.
class SampleFilter {
public:
    SampleFilter() = default;
    /// `radii`: one per place, or one for all; mm. At most the `kMost` nearest samples count.
    SampleFilter(const SurfacePoints& samples, const std::vector<Vec3f>& places, const std::vector<Vec3f>& normals,
                 const std::vector<float>& radii);

    std::vector<Rgb> apply(const std::vector<Rgb>& samples) const;
    Rgb at(std::size_t place, const std::vector<Rgb>& samples) const;
    std::size_t count() const { return first_.empty() ? 0 : first_.size() - 1; }
    std::size_t bytes() const { return terms_.size() * sizeof(Term) + first_.size() * sizeof(std::size_t); }

    static constexpr std::size_t kMost = 64;

private:
    struct Term {
        std::uint32_t sample;
        float weight;
    };
    std::vector<Term> terms_;
    std::vector<std::size_t> first_;
};

/// The nearest sample on the side of a normal; on any side where there is none within a few `reach`.
class NearestSample {
public:
    /// `reach`: mm, how far samples are apart.
    NearestSample(const SurfacePoints& samples, float reach);
    /// `samples` must not be empty.
    std::uint32_t find(const Vec3f& place, const Vec3f& normal) const;

private:
    const SurfacePoints& samples_;
    float reach_;
    PointCells cells_;
};

} // namespace stf
