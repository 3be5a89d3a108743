// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/lateral_filter.h"

#include "stfLib/transport/tile_tracer.h"

namespace stf {

namespace {

constexpr double kWidestVoxels = 1.5;

std::vector<float> gaussian(double sigma, int period) {
    if (period < 2 || !(sigma > 0.2)) {
        return {1.0f};
    }
    const int radius = std::min(int(std::ceil(3 * sigma)), (period - 1) / 2);
    std::vector<float> k;
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) {
        k.push_back(float(std::exp(-0.5 * i * i / (sigma * sigma))));
        sum += double(k.back());
    }
    for (float& w : k) {
        w = float(double(w) / sum);
    }
    return k;
}

double sumOfSquares(const std::vector<float>& k) {
    double sum = 0;
    for (float w : k) {
        sum += double(w) * double(w);
    }
    return sum;
}

} // namespace

LateralFilter::LateralFilter(const BaseVolume& v) : size_(v.size) {
    // Transport mean free path of the densest channel, averaged over the filled voxels.
    double extinction = 0;
    std::size_t filled = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        if (const float k = maxComponent(v.extinction[i]); k > 0) {
            extinction += double(k) * (1 - (v.g.empty() ? 0.0 : double(v.g[i])));
            ++filled;
        }
    }
    const double meanFreePath = extinction > 0 ? double(filled) / extinction : 0;
    kernelX_ = gaussian(std::min(kWidestVoxels, meanFreePath / v.voxelMm.x), size_.x);
    kernelY_ = gaussian(std::min(kWidestVoxels, meanFreePath / v.voxelMm.y), size_.y);
}

LateralFilter::LateralFilter(const Vec3i& size, const Vec3d& voxelMm, double sigmaMm)
    : size_(size), kernelX_(gaussian(sigmaMm / voxelMm.x, size.x)), kernelY_(gaussian(sigmaMm / voxelMm.y, size.y)) {}

void LateralFilter::apply(std::vector<Rgb>& values) const {
    const auto pass = [&](const std::vector<float>& kernel, int length, std::size_t stride, std::size_t start,
                          std::vector<Rgb>& line) {
        const int radius = int(kernel.size()) / 2;
        line.resize(std::size_t(length));
        for (int i = 0; i < length; ++i) {
            Rgb sum(0.0f);
            for (int k = -radius; k <= radius; ++k) {
                sum += values[start + stride * std::size_t(TileTracer::wrap(i + k, length))] *
                       kernel[std::size_t(k + radius)];
            }
            line[std::size_t(i)] = sum;
        }
        for (int i = 0; i < length; ++i) {
            values[start + stride * std::size_t(i)] = line[std::size_t(i)];
        }
    };
    const std::size_t nx = std::size_t(size_.x), ny = std::size_t(size_.y), nz = values.size() / (nx * ny);
    std::vector<Rgb> line;
    for (std::size_t z = 0; z < nz; ++z) {
        for (std::size_t y = 0; y < ny && kernelX_.size() > 1; ++y) {
            pass(kernelX_, size_.x, 1, (z * ny + y) * nx, line);
        }
        for (std::size_t x = 0; x < nx && kernelY_.size() > 1; ++x) {
            pass(kernelY_, size_.y, nx, z * ny * nx + x, line);
        }
    }
}

double LateralFilter::noiseGain() const {
    return 1 / std::sqrt(sumOfSquares(kernelX_) * sumOfSquares(kernelY_));
}

} // namespace stf
