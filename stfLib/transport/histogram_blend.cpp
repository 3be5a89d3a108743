// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/histogram_blend.h"

#include "stfLib/base/gaussian_rank.h"
#include "stfLib/base/parallel.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace stf {

namespace {

/// Axes of less than this share of a layer's variance are left out.
constexpr double kLeastVariance = 1e-4;

FactoredField layerMeans(const FactoredField& field, std::size_t columns) {
    FactoredField m;
    if (field.empty() || columns == 0) {
        return m;
    }
    m.rank = field.rank;
    m.components = field.components;
    m.directions = field.directions;
    m.basis = field.basis;
    const std::size_t width = std::size_t(field.rank) * std::size_t(field.components);
    const std::size_t layers = field.items() / columns;
    m.factors.resize(layers * width);
    std::vector<double> sum(width);
    for (std::size_t z = 0; z < layers; ++z) {
        sum.assign(width, 0.0);
        for (std::size_t i = z * columns; i < (z + 1) * columns; ++i) {
            for (std::size_t k = 0; k < width; ++k) {
                sum[k] += double(field.factors[i * width + k]);
            }
        }
        for (std::size_t k = 0; k < width; ++k) {
            m.factors[z * width + k] = float(sum[k] / double(columns));
        }
    }
    return m;
}

} // namespace

HistogramBlend::HistogramBlend(const TileMedium& medium, const StfTable* table, bool backlight)
    : form_(medium.form()), columns_(std::size_t(medium.size().x) * std::size_t(medium.size().y)) {
    if (medium.hasSurface()) {
        throw Error("a sample with a relief cannot be blended: its surface would be seen twice");
    }
    using Vector = Eigen::Matrix<double, kChannels, 1>;
    using Matrix = Eigen::Matrix<double, kChannels, kChannels>;
    const auto channels = [&](std::size_t i) {
        const TileMedium::Voxel& v = medium.voxel(i);
        Vector x;
        for (int c = 0; c < 3; ++c) {
            // Absorption is the same in the scaled medium and in the true one.
            x[c] = std::max(0.0, double(v.extinction[c]) - double(v.scattering[c]) * double(v.keep));
            x[3 + c] = double(v.scattering[c]);
        }
        x[6] = double(v.g);
        return x;
    };
    const int depth = medium.size().z;
    layers_.resize(std::size_t(depth));
    std::vector<std::vector<Axis>> axesOf(static_cast<std::size_t>(depth));
    std::vector<std::vector<std::vector<float>>> gaussianOf(static_cast<std::size_t>(depth)); // [layer][axis][column]
    parallelFor(std::size_t(depth), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t z = begin; z < end; ++z) {
            Vector mean = Vector::Zero();
            for (std::size_t i = 0; i < columns_; ++i) {
                mean += channels(z * columns_ + i) / double(columns_);
            }
            Matrix covariance = Matrix::Zero();
            for (std::size_t i = 0; i < columns_; ++i) {
                const Vector d = channels(z * columns_ + i) - mean;
                covariance += d * d.transpose() / double(columns_);
            }
            for (int c = 0; c < kChannels; ++c) {
                layers_[z].mean[std::size_t(c)] = float(mean[c]);
            }
            // Coefficients have one unit; the mean cosine counts by what it does to scattering.
            Vector unit = Vector::Ones();
            unit[6] = std::max(1e-12, mean.segment<3>(3).mean());
            const Matrix scaled = unit.asDiagonal() * covariance * unit.asDiagonal();
            const Eigen::SelfAdjointEigenSolver<Matrix> solver(scaled);
            const double all = solver.eigenvalues().cwiseMax(0.0).sum();
            for (int a = kChannels - 1; a >= 0; --a) {
                if (!(solver.eigenvalues()[a] > kLeastVariance * all)) {
                    break;
                }
                const Vector e = solver.eigenvectors().col(a);
                std::vector<float> along(columns_);
                for (std::size_t i = 0; i < columns_; ++i) {
                    along[i] = float(e.dot(unit.asDiagonal() * (channels(z * columns_ + i) - mean)));
                }
                Axis axis;
                const Vector back = unit.cwiseInverse().asDiagonal() * e;
                for (int c = 0; c < kChannels; ++c) {
                    axis.direction[std::size_t(c)] = float(back[c]);
                }
                gaussianOf[z].push_back(gaussianRanks(along));
                const std::vector<float> quantiles = gaussianQuantiles(along, kQuantiles, kReach);
                std::copy(quantiles.begin(), quantiles.end(), axis.quantiles.begin());
                axesOf[z].push_back(axis);
            }
        }
    });
    for (std::size_t z = 0; z < layers_.size(); ++z) {
        layers_[z].firstAxis = int(axes_.size());
        layers_[z].axes = int(axesOf[z].size());
        most_ = std::max(most_, layers_[z].axes);
        axes_.insert(axes_.end(), axesOf[z].begin(), axesOf[z].end());
    }
    gaussian_.assign(medium.voxelCount() * std::size_t(most_), 0.0f);
    for (std::size_t z = 0; z < layers_.size(); ++z) {
        for (std::size_t a = 0; a < gaussianOf[z].size(); ++a) {
            for (std::size_t i = 0; i < columns_; ++i) {
                gaussian_[(z * columns_ + i) * std::size_t(most_) + a] = gaussianOf[z][a][i];
            }
        }
    }
    if (table && medium.scatters()) {
        // A table of one column is the same everywhere: nothing to blend.
        const std::size_t columns = std::size_t(table->size.x) * std::size_t(table->size.y);
        meanMultiple_ = layerMeans(table->multiple.get(), columns);
        if (backlight) {
            meanBacklight_ = layerMeans(table->backlight.get(), columns);
        }
        if (medium.emits()) {
            meanEmitted_ = layerMeans(table->emitted.get(), columns);
        }
    }
}

TileMedium::Voxel HistogramBlend::voxel(const std::array<std::size_t, 3>& column, const BlendPlace& place,
                                        int z) const {
    const Layer& layer = layers_[std::size_t(z)];
    Channels x = layer.mean;
    const float scale = gain(place);
    const std::size_t first = std::size_t(z) * columns_, stride = std::size_t(most_);
    for (int a = 0; a < layer.axes; ++a) {
        float g = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            if (place.weight[i] > 0) {
                g += place.weight[i] * gaussian_[(first + column[i]) * stride + std::size_t(a)];
            }
        }
        const float at =
            std::clamp((g * scale + kReach) * ((kQuantiles - 1) / (2 * kReach)), 0.0f, float(kQuantiles - 1) - 1e-3f);
        const int k = int(at);
        const Axis& axis = axes_[std::size_t(layer.firstAxis + a)];
        const float low = axis.quantiles[std::size_t(k)], high = axis.quantiles[std::size_t(k) + 1];
        const float along = low + (high - low) * (at - float(k));
        for (std::size_t c = 0; c < kChannels; ++c) {
            x[c] += axis.direction[c] * along;
        }
    }
    TileMedium::Voxel v;
    v.g = std::clamp(x[6], -0.999f, 0.999f);
    const DeltaScale s = deltaScale(form_, v.g);
    v.gScaled = form_ == TransportForm::Classic ? 0.0f : s.g;
    v.keep = s.keep;
    for (int c = 0; c < 3; ++c) {
        v.scattering[c] = std::max(0.0f, x[std::size_t(3 + c)]);
        v.extinction[c] = std::max(0.0f, x[std::size_t(c)]) + v.scattering[c] * v.keep;
    }
    return v;
}

std::size_t HistogramBlend::bytes() const {
    return gaussian_.size() * sizeof(float) + axes_.size() * sizeof(Axis) + meanMultiple_.bytes() +
           meanBacklight_.bytes() + meanEmitted_.bytes();
}

} // namespace stf
