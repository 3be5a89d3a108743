// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_solver.h"

#include "stfLib/base/parallel.h"

namespace stf {

namespace {
constexpr float kPi = 3.14159265358979f;
constexpr int kMaxIterations = 200;
constexpr float kTolerance = 1e-3f;

// A sample stands for a disc of its area. Far away the disc is a point; at its own place the kernel's mean over the
// disc is far below its peak. A softened distance r^2 + e^2 meets both: e is where area * kernel equals the disc
// integral.
float softening(const Dipole& dipole, double area) {
    const double wanted = dipole.discIntegral(std::sqrt(area / double(kPi))) / area;
    double lo = 0, hi = area;
    for (int i = 0; i < 60; ++i) {
        const double mid = 0.5 * (lo + hi);
        (double(dipole.kernel(float(mid))) > wanted ? lo : hi) = mid;
    }
    return float(0.5 * (lo + hi));
}
} // namespace

CoreSolver::CoreSolver(const CoreMaterial& m, CoreSamples samples)
    : dipoles_{{m.sigmaA.x, m.sigmaSPrime.x}, {m.sigmaA.y, m.sigmaSPrime.y}, {m.sigmaA.z, m.sigmaSPrime.z}},
      samples_(std::move(samples)) {
    double area = 0;
    for (float a : samples_.areas) {
        area += double(a);
    }
    for (int c = 0; c < 3 && !samples_.areas.empty(); ++c) {
        if (m.sigmaSPrime[c] > 0) {
            soften2_[c] = softening(dipoles_[c], area / double(samples_.areas.size()));
        }
    }
    source_.resize(samples_.positions.size());
    for (std::size_t i = 0; i < source_.size(); ++i) {
        source_[i] = samples_.diffuse[i] + samples_.direct[i];
    }
}

Rgb CoreSolver::gather(const Vec3f& p) const {
    Vec3d sum(0.0), total(0.0);
    for (std::size_t j = 0; j < samples_.positions.size(); ++j) {
        const Vec3f d = samples_.positions[j] - p;
        const float r2 = dot(d, d), area = samples_.areas[j];
        for (int c = 0; c < 3; ++c) {
            const float k = dipoles_[c].kernel(r2 + soften2_[c]) * area;
            sum[c] += double(k * source_[j][c]);
            total[c] += double(k);
        }
    }
    Rgb result(0.0f);
    for (int c = 0; c < 3; ++c) {
        if (total[c] > 0) {
            result[c] = float(dipoles_[c].diffuseAlbedo() * sum[c] / total[c]);
        }
    }
    return result;
}

void CoreSolver::solve(Progress& progress) {
    const std::size_t n = samples_.positions.size();
    // The matrix once, rows scaled to R_cd; the iteration then is a product only.
    std::vector<float> matrix[3];
    for (auto& m : matrix) {
        m.resize(n * n);
    }
    parallelFor(n, 16, [&](std::size_t begin, std::size_t end) {
        if (progress.cancelled()) {
            throw Cancelled();
        }
        for (std::size_t i = begin; i < end; ++i) {
            for (int c = 0; c < 3; ++c) {
                float* const row = matrix[c].data() + i * n;
                double total = 0;
                for (std::size_t j = 0; j < n; ++j) {
                    const Vec3f d = samples_.positions[j] - samples_.positions[i];
                    row[j] = dipoles_[c].kernel(dot(d, d) + soften2_[c]) * samples_.areas[j];
                    total += double(row[j]);
                }
                const float scale = total > 0 ? float(dipoles_[c].diffuseAlbedo() / total) : 0.0f;
                for (std::size_t j = 0; j < n; ++j) {
                    row[j] *= scale;
                }
            }
        }
    });
    std::vector<Rgb> exitance(n, Rgb(0.0f)), next(n);
    for (iterations_ = 1; iterations_ <= kMaxIterations; ++iterations_) {
        progress.update("core", double(iterations_) / kMaxIterations);
        parallelFor(n, 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                for (int c = 0; c < 3; ++c) {
                    const float* const row = matrix[c].data() + i * n;
                    double sum = 0;
                    for (std::size_t j = 0; j < n; ++j) {
                        sum += double(row[j] * source_[j][c]);
                    }
                    next[i][c] = float(sum);
                }
            }
        });
        float change = 0, largest = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3f d = next[i] - exitance[i];
            change = std::max(change, std::max(std::abs(d.x), std::max(std::abs(d.y), std::abs(d.z))));
            largest = std::max(largest, maxComponent(next[i]));
            source_[i] = samples_.diffuse[i] + samples_.direct[i] + samples_.shellReflectance[i] * next[i];
        }
        exitance.swap(next);
        // The geometric series converges with the product of both reflectances: stop where its rest is below 0.1 %.
        float ratio = 0;
        for (std::size_t i = 0; i < n; ++i) {
            for (int c = 0; c < 3; ++c) {
                ratio = std::max(ratio, samples_.shellReflectance[i][c] * float(dipoles_[c].diffuseAlbedo()));
            }
        }
        if (change <= kTolerance * (1 - std::min(ratio, 0.99f)) * largest) {
            break;
        }
    }
}

Rgb CoreSolver::exitance(const Vec3f& positionMm) const {
    return gather(positionMm);
}

} // namespace stf
