// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_solver.h"

#include "stfLib/base/parallel.h"

#include <array>
#include <map>

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

void CoreSolver::buildClusters() {
    const std::size_t n = samples_.positions.size();
    Box3f box;
    double area = 0;
    for (std::size_t i = 0; i < n; ++i) {
        box.add(samples_.positions[i]);
        area += double(samples_.areas[i]);
    }
    // Cells of a grid that hold about sqrt(n) samples each balance the two levels of the sum.
    const float cell = float(std::sqrt(area / std::max(1.0, std::sqrt(double(n)))));
    std::map<std::array<int, 3>, std::vector<std::size_t>> cells;
    for (std::size_t i = 0; i < n && cell > 0; ++i) {
        const Vec3f p = (samples_.positions[i] - box.lo) / cell;
        cells[{int(p.x), int(p.y), int(p.z)}].push_back(i);
    }
    clusters_.clear();
    order_.clear();
    for (const auto& [key, members] : cells) {
        Cluster c;
        c.first = order_.size();
        c.count = members.size();
        Vec3d centre(0.0), flux(0.0);
        double sum = 0;
        for (std::size_t i : members) {
            const double a = double(samples_.areas[i]);
            centre += Vec3d(samples_.positions[i]) * a;
            flux += Vec3d(source_[i]) * a;
            sum += a;
            order_.push_back(i);
        }
        c.centre = Vec3f(centre / sum);
        c.flux = Rgb(flux);
        c.area = float(sum);
        for (std::size_t i : members) {
            c.radius = std::max(c.radius, length(samples_.positions[i] - c.centre));
        }
        clusters_.push_back(c);
    }
}

Rgb CoreSolver::exitance(const Vec3f& p, float opening) const {
    Vec3d sum(0.0), total(0.0);
    const auto add = [&](const Vec3f& at, float area, const Rgb& flux) {
        const Vec3f d = at - p;
        const float r2 = dot(d, d);
        for (int c = 0; c < 3; ++c) {
            const float k = dipoles_[c].tabulated(r2 + soften2_[c]);
            sum[c] += double(k * flux[c]);
            total[c] += double(k * area);
        }
    };
    for (const Cluster& c : clusters_) {
        if (c.radius < opening * length(c.centre - p)) {
            add(c.centre, c.area, c.flux);
            continue;
        }
        for (std::size_t k = c.first; k < c.first + c.count; ++k) {
            const std::size_t i = order_[k];
            add(samples_.positions[i], samples_.areas[i], source_[i] * samples_.areas[i]);
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
                    row[j] = dipoles_[c].tabulated(dot(d, d) + soften2_[c]) * samples_.areas[j];
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
    buildClusters();
}

} // namespace stf
