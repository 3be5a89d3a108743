// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/lateral_filter.h"

#include "stfLib/base/parallel.h"
#include "stfLib/transport/tile_tracer.h"

namespace stf {

namespace {

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

// out[i] = sum over k of kernel[k] in[i + k], rows of `width` numbers that follow each other periodically.
void convolve(const std::vector<float>& kernel, const float* in, int rows, int width, float* out) {
    const int radius = int(kernel.size()) / 2;
    for (int i = 0; i < rows; ++i) {
        float* const o = out + std::ptrdiff_t(i) * width;
        std::fill(o, o + width, 0.0f);
        for (int k = -radius; k <= radius; ++k) {
            const float* const p = in + std::ptrdiff_t(TileTracer::wrap(i + k, rows)) * width;
            const float w = kernel[std::size_t(k + radius)];
            for (int j = 0; j < width; ++j) {
                o[j] += w * p[j];
            }
        }
    }
}

} // namespace

LateralFilter::LateralFilter(const Vec3i& size, const Vec3d& voxelMm, double sigmaMm)
    : size_(size), kernelX_(gaussian(sigmaMm / voxelMm.x, size.x)), kernelY_(gaussian(sigmaMm / voxelMm.y, size.y)) {}

void LateralFilter::applyLayer(float* values, int components, const float* fill) const {
    if (none()) {
        return;
    }
    const std::size_t items = std::size_t(size_.x) * std::size_t(size_.y), n = std::size_t(components);
    const auto smooth = [&](std::vector<float>& v, int width) {
        std::vector<float> other(v.size());
        for (int y = 0; y < size_.y; ++y) {
            const std::ptrdiff_t row = std::ptrdiff_t(y) * size_.x * width;
            convolve(kernelX_, v.data() + row, size_.x, width, other.data() + row);
        }
        convolve(kernelY_, other.data(), size_.y, size_.x * width, v.data());
    };
    std::vector<float> v(values, values + items * n), weight;
    if (fill) {
        weight.assign(fill, fill + items);
        for (std::size_t i = 0; i < items * n; ++i) {
            v[i] *= fill[i / n];
        }
        smooth(weight, 1);
    }
    smooth(v, components);
    for (std::size_t i = 0; i < items * n; ++i) {
        values[i] = !fill ? v[i] : weight[i / n] > 1e-6f ? v[i] / weight[i / n] : 0.0f;
    }
}

void LateralFilter::apply(std::vector<float>& values, int components, const std::vector<float>& fill) const {
    if (none()) {
        return;
    }
    const std::size_t items = std::size_t(size_.x) * std::size_t(size_.y), layer = items * std::size_t(components);
    parallelFor(values.size() / layer, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z) {
            applyLayer(values.data() + z * layer, components, fill.empty() ? nullptr : fill.data() + z * items);
        }
    });
}

void LateralFilter::apply(std::vector<Rgb>& values) const {
    std::vector<float> flat;
    flat.reserve(values.size() * 3);
    for (const Rgb& v : values) {
        flat.insert(flat.end(), {v.x, v.y, v.z});
    }
    apply(flat, 3, {});
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = {flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]};
    }
}

} // namespace stf
