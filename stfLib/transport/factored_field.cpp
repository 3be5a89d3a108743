// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/factored_field.h"

#include "stfLib/base/error.h"
#include "stfLib/base/parallel.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stf {

// ---- lights

void FoldedLight::clear(const FactoredField& field) {
    factors_.assign(std::size_t(field.rank) * 4, Rgb(0.0f));
    dark_ = true;
}

void FoldedLight::add(const FactoredField& field, const DirectionSet& directions, const Vec3f& towardsLight,
                      const Rgb& irradiance, const Vec3f& towardsViewer) {
    const DirectionWeights w = directions.weights(towardsLight);
    if (w.count == 0 || field.rank == 0 || irradiance == Rgb(0.0f)) {
        return;
    }
    const std::size_t rank = std::size_t(field.rank);
    if (factors_.size() != rank * 4) {
        clear(field);
    }
    dark_ = false;
    sums_.assign(rank * 2, 0.0f);
    float* const even = sums_.data();
    float* const odd = even + rank;
    for (int i = 0; i < w.count; ++i) {
        const float* const b = field.basis.data() + std::size_t(w.index[i]) * rank;
        const float sign = i < w.count - w.across ? 1.0f : -1.0f;
        for (std::size_t k = 0; k < rank; ++k) {
            even[k] += w.weight[i] * b[k];
            odd[k] += sign * w.weight[i] * b[k];
        }
    }
    if (!field.hasFlux()) {
        for (std::size_t k = 0; k < rank; ++k) {
            factors_[4 * k] += irradiance * even[k];
        }
        return;
    }
    // Averaged over azimuth, the axes turn with the light: radial and tangential flux is odd across the pole.
    Vec3f along = towardsViewer;
    const bool turning = directions.azimuths() == 1;
    if (turning) {
        const float r = std::sqrt(towardsLight.x * towardsLight.x + towardsLight.y * towardsLight.y);
        const Vec3f radial = r > 0 ? Vec3f(towardsLight.x / r, towardsLight.y / r, 0) : Vec3f(1, 0, 0);
        along.x = dot(radial, towardsViewer);
        along.y = dot(Vec3f(-radial.y, radial.x, 0), towardsViewer);
    }
    const float* const horizontal = turning ? odd : even;
    for (std::size_t k = 0; k < rank; ++k) {
        Rgb* const f = factors_.data() + 4 * k;
        f[0] += irradiance * even[k];
        f[1] += irradiance * (horizontal[k] * along.x);
        f[2] += irradiance * (horizontal[k] * along.y);
        f[3] += irradiance * (even[k] * along.z);
    }
}

// ---- values

float FactoredField::node(std::size_t item, int direction, int component) const {
    if (rank == 0) {
        return 0;
    }
    double sum = 0;
    const float* a = factors.data() + item * std::size_t(rank) * std::size_t(components) + component;
    const float* const b = basis.data() + std::size_t(direction) * std::size_t(rank);
    for (int k = 0; k < rank; ++k, a += components) {
        sum += double(*a) * double(b[k]);
    }
    return float(sum);
}

Rgb FactoredField::rgb(std::size_t item, const DirectionWeights& w) const {
    Rgb sum(0.0f);
    const float* a = factors.data() + item * std::size_t(rank) * std::size_t(components);
    for (int k = 0; k < rank; ++k, a += components) {
        float b = 0;
        for (int i = 0; i < w.count; ++i) {
            b += w.weight[i] * basis[std::size_t(w.index[i]) * std::size_t(rank) + std::size_t(k)];
        }
        sum += Rgb(a[0], a[1], a[2]) * b;
    }
    return sum;
}

FactoredField FactoredField::single(std::vector<float> values, int components) {
    FactoredField field;
    field.components = components;
    field.directions = 1;
    if (!values.empty()) {
        field.rank = 1;
        field.factors = std::move(values);
        field.basis = {1.0f};
    }
    return field;
}

// ---- factorisation

namespace {

using Matrix = Eigen::MatrixXd;

/// Energy below this share of the whole is rounding of floats and of the eigenvalues.
constexpr double kRounding = 1e-13;
/// Items of one partial sum. They are added in order, so that threads do not change the result.
constexpr std::size_t kGrain = 1024;
constexpr int kLargest = 13; ///< exponent of the largest |a_k|: in [2^12, 2^13)

// A stretch of the values as a matrix, one column per direction.
void load(const std::vector<std::vector<float>>& values, std::size_t begin, std::size_t end, Matrix& block) {
    block.resize(Eigen::Index(end - begin), Eigen::Index(values.size()));
    for (std::size_t d = 0; d < values.size(); ++d) {
        std::copy(values[d].begin() + std::ptrdiff_t(begin), values[d].begin() + std::ptrdiff_t(end),
                  block.col(Eigen::Index(d)).data());
    }
}

Matrix gramOf(const std::vector<std::vector<float>>& values, const std::vector<float>& weights) {
    const Eigen::Index n = Eigen::Index(values.size());
    const std::size_t count = values[0].size(), chunks = (count + kGrain - 1) / kGrain, round = 64;
    Matrix gram = Matrix::Zero(n, n);
    std::vector<Matrix> partial(std::min(round, chunks));
    for (std::size_t first = 0; first < chunks; first += round) {
        const std::size_t now = std::min(round, chunks - first);
        parallelFor(now, 1, [&](std::size_t chunk, std::size_t) {
            const std::size_t begin = (first + chunk) * kGrain, end = std::min(count, begin + kGrain);
            Matrix block;
            load(values, begin, end, block);
            if (!weights.empty()) {
                for (std::size_t i = begin; i < end; ++i) {
                    block.row(Eigen::Index(i - begin)) *= std::sqrt(std::max(0.0, double(weights[i])));
                }
            }
            partial[chunk].setZero(n, n);
            partial[chunk].selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
        });
        for (std::size_t chunk = 0; chunk < now; ++chunk) {
            gram += partial[chunk];
        }
    }
    return gram.selfadjointView<Eigen::Lower>();
}

void check(const std::vector<std::vector<float>>& values, int components, const FactoriseOptions& options) {
    bool agree = components > 0 && (values.empty() || values[0].size() % std::size_t(std::max(1, components)) == 0);
    for (const std::vector<float>& v : values) {
        agree = agree && v.size() == values[0].size();
    }
    agree = agree && (options.weights.empty() || (!values.empty() && options.weights.size() == values[0].size()));
    agree = agree && (options.noiseGram.empty() || options.noiseGram.size() == values.size() * values.size());
    if (!agree) {
        throw Error("the lengths of what is to be factored do not agree");
    }
}

} // namespace

FactoredField factorise(const std::vector<std::vector<float>>& values, int components, const FactoriseOptions& options,
                        FactoriseReport* report) {
    check(values, components, options);
    if (report) {
        *report = {};
    }
    FactoredField field;
    field.components = components;
    field.directions = int(values.size());
    if (values.empty() || values[0].empty()) {
        return field;
    }
    const Eigen::Index n = Eigen::Index(values.size());
    Matrix signal = gramOf(values, options.weights), noise = Matrix::Zero(n, n);
    if (!options.noiseGram.empty()) {
        noise = Eigen::Map<const Matrix>(options.noiseGram.data(), n, n);
        noise = (0.5 * (noise + noise.transpose())).eval();
        signal -= noise;
    }
    if (!signal.allFinite()) {
        throw Error("what is to be factored holds values that are not finite");
    }
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(signal);
    if (solver.info() != Eigen::Success) {
        throw Error("the eigenvalues of a field were not found");
    }

    // From the largest eigenvalue on, those with more signal than noise.
    const double energy = signal.trace();
    // What is left to keep. Noise taken off makes some eigenvalues negative: a sum with those in it would be gone before
    // all factors are kept that can be told from noise.
    double left = solver.eigenvalues().cwiseMax(0.0).sum(), noisePower = 0;
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = n - 1; k >= 0; --k) {
        const auto vector = solver.eigenvectors().col(k);
        const double own = solver.eigenvalues()[k], noiseOwn = vector.dot(noise * vector);
        if (!(energy > 0) || int(kept.size()) >= options.maxRank ||
            left <= options.tolerance * options.tolerance * energy) {
            break;
        }
        if (own > options.noiseRead * noiseOwn && own > kRounding * energy) {
            kept.push_back(k);
            left -= own;
            noisePower += noiseOwn;
        }
    }
    if (report && energy > 0) {
        // Summed from the small ones up: `left` has lost digits.
        double dropped = 0;
        for (Eigen::Index k = 0; k < n; ++k) {
            dropped += std::find(kept.begin(), kept.end(), k) == kept.end() ? solver.eigenvalues()[k] : 0.0;
        }
        report->truncation = std::sqrt(std::max(0.0, dropped) / energy);
        report->noise = std::sqrt(std::max(0.0, noisePower) / energy);
    }
    field.rank = int(kept.size());
    if (kept.empty()) {
        return field;
    }

    const Eigen::Index rank = field.rank;
    Matrix basis(n, rank);
    for (Eigen::Index k = 0; k < rank; ++k) {
        basis.col(k) = solver.eigenvectors().col(kept[std::size_t(k)]);
        Eigen::Index largest = 0;
        basis.col(k).cwiseAbs().maxCoeff(&largest);
        if (basis(largest, k) < 0) {
            basis.col(k) = -basis.col(k); // eigenvectors have no sign of their own
        }
    }
    // Project, then fold the scale of each factor into its basis; powers of two round nothing.
    const std::size_t count = values[0].size(), width = std::size_t(components), stride = width * std::size_t(rank);
    const std::size_t items = count / width;
    field.factors.resize(items * stride);
    const std::size_t grain = std::max<std::size_t>(1, kGrain / width);
    std::vector<Eigen::VectorXd> largest((items + grain - 1) / grain);
    parallelFor(items, grain, [&](std::size_t begin, std::size_t end) {
        Matrix block;
        load(values, begin * width, end * width, block);
        const Matrix projected = block * basis;
        largest[begin / grain] = projected.cwiseAbs().colwise().maxCoeff();
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t k = 0; k < std::size_t(rank); ++k) {
                for (std::size_t c = 0; c < width; ++c) {
                    field.factors[i * stride + k * width + c] =
                        float(projected(Eigen::Index((i - begin) * width + c), Eigen::Index(k)));
                }
            }
        }
    });
    std::vector<float> scale(std::size_t(rank), 1.0f);
    field.basis.resize(std::size_t(n * rank));
    for (Eigen::Index k = 0; k < rank; ++k) {
        double most = 0;
        for (const Eigen::VectorXd& m : largest) {
            most = std::max(most, m[k]);
        }
        int exponent = 0;
        std::frexp(float(most), &exponent);
        exponent = std::clamp(kLargest - exponent, -126, 126);
        scale[std::size_t(k)] = std::ldexp(1.0f, exponent);
        for (Eigen::Index d = 0; d < n; ++d) {
            field.basis[std::size_t(d * rank + k)] = float(std::ldexp(basis(d, k), -exponent));
        }
    }
    parallelFor(items, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t k = 0; k < std::size_t(rank); ++k) {
                for (std::size_t c = 0; c < width; ++c) {
                    field.factors[i * stride + k * width + c] *= scale[k];
                }
            }
        }
    });
    return field;
}

} // namespace stf
