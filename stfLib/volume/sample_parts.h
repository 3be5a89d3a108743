// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to stfLib's sources: what the modelled samples are made of.
#include "stfLib/volume/make_samples.h"

#include <cmath>

namespace stf {

/// Gradient noise (Perlin 2002) over the tile of a volume, about -1 to 1, periodic in x and y.
class TileNoise {
public:
    TileNoise(const BaseVolume& volume, std::uint32_t seed);
    /// `cells` lattice cells (a power of two) along the tile; `salt` tells one noise from another.
    float operator()(const Vec3d& mm, int cells, std::uint32_t salt) const;
    /// Octaves from `cells` on, each of twice the cells and half the height.
    double fractal(const Vec3d& mm, int cells, int octaves, std::uint32_t salt) const;

private:
    double tileX_, tileY_; // mm
    std::uint32_t seed_;
};

/// Balls at random places in a tile, periodic in x and y.
struct Ball {
    Vec3d middle; ///< mm
    double radius;
};
/// Signed distance in mm to the nearest ball's surface, positive inside the ball; across the sides of the tile, too.
double depthInBalls(const std::vector<Ball>& balls, const Vec3d& mm, const Vec3d& extentMm);

/// 0 below lo, 1 above hi, smooth in between; falling where lo > hi.
double smoothStep(double lo, double hi, double x);

/// A volume of the sample's own size, unless the options say another, with extinction and albedo of zero.
BaseVolume blankSample(const char* name, const SampleOptions& options, const Vec3i& size, double voxelMm);

/// Grey extinction, colour by absorption: walks then carry all channels at once, without spectral noise.
/// `extinction` and `sigmaA` in 1/mm, `coverage` the share of the voxel that is filled.
void setMedium(BaseVolume& v, std::size_t i, const Vec3d& sigmaA, double extinction, double coverage);

/// A relief over the columns of a tile (x fastest), given by its depth below the tile's top in mm at places in mm.
class Relief {
public:
    /// `depthAt(x, y)` is called a little outside of the tile, too; slopes come from a quarter of a voxel to both
    /// sides.
    template<class DepthAt>
    Relief(const BaseVolume& v, const DepthAt& depthAt) : columns_(std::size_t(v.size.x) * std::size_t(v.size.y)) {
        const double e = 0.25 * v.voxelMm.x;
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            const double x = (double(i % std::size_t(v.size.x)) + 0.5) * v.voxelMm.x;
            const double y = (double(i / std::size_t(v.size.x)) + 0.5) * v.voxelMm.y;
            const double sx = (depthAt(x + e, y) - depthAt(x - e, y)) / (2 * e);
            const double sy = (depthAt(x, y + e) - depthAt(x, y - e)) / (2 * e);
            columns_[i] = {depthAt(x, y), std::sqrt(1 + sx * sx + sy * sy)};
        }
    }
    /// Of the column that a voxel (by its index in the volume) is in, mm.
    double depth(std::size_t voxel) const { return columns_[voxel % columns_.size()].depth; }
    /// Distance of a depth z in that column to the relief's tangent plane, mm: exact for a plane, positive outside.
    double distance(std::size_t voxel, double z) const {
        const Column& c = columns_[voxel % columns_.size()];
        return (c.depth - z) / c.stretch;
    }

private:
    struct Column {
        double depth, stretch;
    };
    std::vector<Column> columns_;
};

/// Calls f(index, middle of the voxel in mm).
template<class F>
void forEachVoxel(const BaseVolume& v, F f) {
    for (int z = 0; z < v.size.z; ++z) {
        for (int y = 0; y < v.size.y; ++y) {
            for (int x = 0; x < v.size.x; ++x) {
                f(v.index(x, y, z), Vec3d((x + 0.5) * v.voxelMm.x, (y + 0.5) * v.voxelMm.y, (z + 0.5) * v.voxelMm.z));
            }
        }
    }
}

} // namespace stf
