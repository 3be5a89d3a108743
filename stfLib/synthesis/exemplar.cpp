// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/exemplar.h"

#include "stfLib/base/parallel.h"
#include "stfLib/optics/semi_infinite.h"
#include "stfLib/synthesis/column_response.h"
#include "stfLib/synthesis/similar_texels.h"
#include "stfLib/volume/volume_statistics.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stf {

namespace {

constexpr int kStackLevels = 5;
constexpr int kSimilar = 8;
constexpr double kLogWeight = 6;            ///< steps of lightness per factor of ten in a coefficient, at the top
constexpr double kLightness = 116;          ///< CIE lightness per cube root of reflectance
constexpr double kHeightWeight = 12;        ///< steps of lightness per texel of height: what a slope does to shading
constexpr std::size_t kMostSamples = 16384; ///< neighbourhoods that the principal components are taken from

int wrap(int i, int n) {
    const int r = i % n;
    return r < 0 ? r + n : r;
}

/// Depth of the surface below the top of the tile, mm: the first sign change in a column.
double surfaceDepth(const BaseVolume& v, int x, int y) {
    if (v.surface.empty()) {
        return 0;
    }
    const auto sdf = [&](int z) { return double(v.surface[v.index(x, y, z)]); };
    if (sdf(0) <= 0) {
        return std::max(0.0, 0.5 * v.voxelMm.z + sdf(0));
    }
    for (int z = 1; z < v.size.z; ++z) {
        if (sdf(z) <= 0) {
            const double t = sdf(z - 1) / std::max(1e-12, sdf(z - 1) - sdf(z));
            return (z - 0.5 + t) * v.voxelMm.z;
        }
    }
    return v.size.z * v.voxelMm.z;
}

struct Coefficients {
    Vec3d sigmaS, sigmaA;
};

Coefficients coefficientsOf(const BaseVolume& v, std::size_t i) {
    const double g = v.g.empty() ? 0 : double(v.g[i]);
    const Vec3d kappa(v.extinction[i]), albedo(v.albedo[i]);
    return {kappa * albedo * (1 - g), kappa * (Vec3d(1.0) - albedo)};
}

/// Features per column, before neighbourhoods: rows of `count` numbers.
struct ColumnFeatures {
    int count = 0;
    std::vector<float> values;
};

ColumnFeatures columnFeatures(const BaseVolume& v, const std::vector<Rgb>& response) {
    // Means of the whole tile: the floor below which a coefficient is nothing, and how light fades with depth.
    Vec3d meanS, meanA;
    std::size_t filled = 0;
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        if (maxComponent(v.extinction[i]) > 0) {
            const Coefficients c = coefficientsOf(v, i);
            meanS += c.sigmaS;
            meanA += c.sigmaA;
            ++filled;
        }
    }
    const double share = 1 / double(std::max<std::size_t>(1, filled));
    const Vec3d floorS = meanS * (1e-2 * share), floorA = meanA * (1e-2 * share);
    const double a = average(meanA) * share, s = average(meanS) * share;
    const double decay = std::sqrt(3 * a * (a + s)) + 0.1 / std::max(1e-12, v.extentMm().z);

    struct Band {
        int from, to;
        double weight;
    };
    std::vector<Band> bands;
    for (int from = 0, size = 1; from < v.size.z; from += size, size *= 2) {
        const int to = std::min(v.size.z, from + size);
        bands.push_back({from, to, std::exp(-decay * 0.5 * (from + to) * v.voxelMm.z)});
    }
    ColumnFeatures f;
    f.count = int(bands.size()) * 6 + 4;
    f.values.assign(std::size_t(v.size.x) * std::size_t(v.size.y) * std::size_t(f.count), 0);
    double bandSum = 0;
    for (const Band& b : bands) {
        bandSum += b.weight;
    }
    parallelFor(std::size_t(v.size.y), 8, [&](std::size_t begin, std::size_t end) {
        for (int y = int(begin); y < int(end); ++y) {
            for (int x = 0; x < v.size.x; ++x) {
                const std::size_t column = std::size_t(y) * std::size_t(v.size.x) + std::size_t(x);
                float* out = &f.values[column * std::size_t(f.count)];
                for (const Band& b : bands) {
                    Vec3d sumS, sumA;
                    for (int z = b.from; z < b.to; ++z) {
                        const std::size_t i = v.index(x, y, z);
                        if (v.surface.empty() || v.surface[i] <= 0) {
                            const Coefficients c = coefficientsOf(v, i);
                            sumS += c.sigmaS;
                            sumA += c.sigmaA;
                        }
                    }
                    const double w = kLogWeight * std::sqrt(b.weight / bandSum), n = b.to - b.from;
                    for (int c = 0; c < 3; ++c) {
                        *out++ = floorS[c] > 0 ? float(w * std::log10(sumS[c] / n / floorS[c] + 1)) : 0.0f;
                        *out++ = floorA[c] > 0 ? float(w * std::log10(sumA[c] / n / floorA[c] + 1)) : 0.0f;
                    }
                }
                *out++ = float(-kHeightWeight * surfaceDepth(v, x, y) / v.voxelMm.x);
                for (int c = 0; c < 3; ++c) {
                    // Three channels weigh as one lightness.
                    *out++ = float(kLightness / std::sqrt(3.0) * std::cbrt(double(response[column][c])));
                }
            }
        }
    });
    return f;
}

/// Projects neighbourhoods of 5 x 5 columns to the first components.
AppearanceImage project(const ColumnFeatures& f, int width, int height, double& kept) {
    constexpr int radius = 2, places = 25;
    double weight[places], sum = 0;
    for (int k = 0; k < places; ++k) {
        const int dx = k % 5 - radius, dy = k / 5 - radius;
        sum += weight[k] = std::exp(-0.5 * (dx * dx + dy * dy) / 1.2);
    }
    // Normalised, so that distances stay those of columns.
    for (double& w : weight) {
        w = std::sqrt(w / sum);
    }
    const int wide = f.count * places;
    const auto gather = [&](int x, int y, float* out) {
        for (int k = 0; k < places; ++k) {
            const std::size_t column = std::size_t(wrap(y + k / 5 - radius, height)) * std::size_t(width) +
                                       std::size_t(wrap(x + k % 5 - radius, width));
            for (int c = 0; c < f.count; ++c) {
                *out++ = float(weight[k]) * f.values[column * std::size_t(f.count) + std::size_t(c)];
            }
        }
    };
    const std::size_t texels = std::size_t(width) * std::size_t(height);
    const std::size_t stride = (texels + kMostSamples - 1) / kMostSamples;
    const std::size_t samples = (texels + stride - 1) / stride;
    Eigen::MatrixXf data(wide, Eigen::Index(samples));
    parallelFor(samples, 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t t = i * stride;
            gather(int(t % std::size_t(width)), int(t / std::size_t(width)), data.col(Eigen::Index(i)).data());
        }
    });
    const Eigen::VectorXf mean = data.rowwise().mean();
    data.colwise() -= mean;
    const Eigen::MatrixXf covariance = data * data.transpose() / float(samples);
    // The leading components by orthogonal iteration: a few of some hundred do not ask for a full decomposition.
    constexpr int dims = AppearanceImage::dims;
    const int used = std::min(dims, wide);
    Eigen::MatrixXf basis = Eigen::MatrixXf::Zero(wide, used);
    for (int d = 0; d < used; ++d) {
        for (int i = 0; i < wide; ++i) {
            basis(i, d) = float(std::sin(1.0 + 1.7 * (d + 1) * i + 0.31 * d));
        }
    }
    for (int step = 0; step < 40; ++step) {
        const Eigen::MatrixXf next = covariance * basis;
        const float scale = next.cwiseAbs().maxCoeff();
        if (!(scale > 1e-20f)) {
            break; // nothing varies
        }
        Eigen::HouseholderQR<Eigen::MatrixXf> qr(next / scale);
        basis = qr.householderQ() * Eigen::MatrixXf::Identity(wide, used);
    }
    const double all = double(covariance.trace());
    kept = all > 0 ? double((basis.transpose() * covariance * basis).trace()) / all : 1;

    AppearanceImage image;
    image.width = width;
    image.height = height;
    image.texels.resize(texels);
    parallelFor(texels, 1024, [&](std::size_t begin, std::size_t end) {
        Eigen::VectorXf column(wide);
        for (std::size_t t = begin; t < end; ++t) {
            gather(int(t % std::size_t(width)), int(t / std::size_t(width)), column.data());
            const Eigen::VectorXf p = basis.transpose() * (column - mean);
            image.texels[t] = {};
            for (int d = 0; d < used; ++d) {
                image.texels[t][std::size_t(d)] = p[d];
            }
        }
    });
    return image;
}

/// Periodic Gaussian of `sigma` texels.
AppearanceImage blurred(const AppearanceImage& in, double sigma) {
    const int radius = int(std::ceil(3 * sigma));
    std::vector<float> weight(std::size_t(2 * radius + 1));
    float sum = 0;
    for (int i = -radius; i <= radius; ++i) {
        sum += weight[std::size_t(i + radius)] = float(std::exp(-0.5 * i * i / (sigma * sigma)));
    }
    AppearanceImage current = in;
    for (int axis = 0; axis < 2; ++axis) {
        AppearanceImage next = current;
        parallelFor(std::size_t(in.height), 8, [&](std::size_t begin, std::size_t end) {
            for (int y = int(begin); y < int(end); ++y) {
                for (int x = 0; x < in.width; ++x) {
                    AppearanceImage::Value v{};
                    for (int i = -radius; i <= radius; ++i) {
                        const AppearanceImage::Value& s = axis == 0 ? current.at(x + i, y) : current.at(x, y + i);
                        for (std::size_t d = 0; d < v.size(); ++d) {
                            v[d] += weight[std::size_t(i + radius)] / sum * s[d];
                        }
                    }
                    next.texels[std::size_t(y) * std::size_t(in.width) + std::size_t(x)] = v;
                }
            }
        });
        current = std::move(next);
    }
    return current;
}

void addParameters(const BaseVolume& v, Exemplar& e) {
    const std::size_t columns = e.texelCount();
    std::vector<float> extinction(columns), albedo(columns), height(columns);
    for (std::size_t i = 0; i < columns; ++i) {
        const int x = int(i % std::size_t(e.width)), y = int(i / std::size_t(e.width));
        double sumE = 0, sumS = 0;
        for (int z = 0; z < v.size.z; ++z) {
            const std::size_t k = v.index(x, y, z);
            sumE += double(v.extinction[k].y);
            sumS += double(v.extinction[k].y * v.albedo[k].y);
        }
        extinction[i] = float(std::log10(sumE / v.size.z + 1e-12));
        albedo[i] = float(sumE > 0 ? sumS / sumE : 0.0);
        height[i] = float(-surfaceDepth(v, x, y));
    }
    const auto add = [&](const char* name, std::vector<float>& values) {
        const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
        // What is rounding is no distribution.
        if (*hi - *lo > 1e-5f * std::max(1e-6f, std::max(std::abs(*lo), std::abs(*hi)))) {
            e.parameterNames.push_back(name);
            e.parameters.push_back(std::move(values));
        }
    };
    add("extinction", extinction);
    add("albedo", albedo);
    add("height", height);
    std::vector<float> response(columns);
    for (std::size_t i = 0; i < columns; ++i) {
        response[i] = luminance(e.response[i]);
    }
    add("response", response);
}

} // namespace

int Exemplar::wrapX(int x) const {
    return wrap(x, width);
}
int Exemplar::wrapY(int y) const {
    return wrap(y, height);
}

const AppearanceImage::Value& AppearanceImage::at(int x, int y) const {
    return texels[std::size_t(wrap(y, height)) * std::size_t(width) + std::size_t(wrap(x, width))];
}

AppearanceImage::Value AppearanceImage::sample(float x, float y) const {
    const float fx = std::floor(x - 0.5f), fy = std::floor(y - 0.5f);
    const float u = x - 0.5f - fx, v = y - 0.5f - fy;
    const int x0 = wrap(int(fx), width), y0 = wrap(int(fy), height);
    const int x1 = x0 + 1 == width ? 0 : x0 + 1, y1 = y0 + 1 == height ? 0 : y0 + 1;
    const std::size_t w = std::size_t(width);
    const Value &a = texels[std::size_t(y0) * w + std::size_t(x0)], &b = texels[std::size_t(y0) * w + std::size_t(x1)],
                &c = texels[std::size_t(y1) * w + std::size_t(x0)], &d = texels[std::size_t(y1) * w + std::size_t(x1)];
    const float wa = (1 - u) * (1 - v), wb = u * (1 - v), wc = (1 - u) * v, wd = u * v;
    Value out;
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i];
    }
    return out;
}

float squaredDistance(const AppearanceImage::Value& a, const AppearanceImage::Value& b) {
    float sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    }
    return sum;
}

Exemplar makeExemplar(const BaseVolume& volume, const std::vector<Rgb>& response, Progress& progress) {
    Exemplar e;
    e.width = volume.size.x;
    e.height = volume.size.y;
    e.texelMm = {volume.voxelMm.x, volume.voxelMm.y};
    e.response = response.empty() ? columnResponse(volume) : response;
    if (e.response.size() != e.texelCount()) {
        throw Error("the response to light does not have one value per column of the sample");
    }
    progress.update("appearance space", 0);
    e.stack.push_back(project(columnFeatures(volume, e.response), e.width, e.height, e.keptVariance));
    progress.update("appearance space", 0.4);
    for (int l = 1; l < kStackLevels && (1 << l) < std::min(e.width, e.height); ++l) {
        e.stack.push_back(blurred(e.stack[0], 0.5 * (1 << l)));
    }
    progress.update("appearance space", 0.6);
    e.similarCount = kSimilar;
    e.similar = similarTexels(e.stack[0], kSimilar);
    progress.update("appearance space", 0.8);
    e.similarCoarse = similarTexels(e.stack[std::min<std::size_t>(2, e.stack.size() - 1)], kSimilar);
    e.ownError = ownNeighbourhoodError(e.stack[0], e.similar, kSimilar);
    addParameters(volume, e);
    Material mean;
    mean.sigmaA = meanCoefficients(volume).sigmaA;
    mean.sigmaS = meanCoefficients(volume).sigmaSPrime;
    e.diffusionMm = diffusionLengthMm(mean);
    progress.update("appearance space", 1);
    return e;
}

} // namespace stf
