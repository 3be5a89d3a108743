// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/core_solver.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {
constexpr int kMaxIterations = 200;
constexpr float kTolerance = 1e-3f;
} // namespace

CoreSolver::CoreSolver(std::shared_ptr<const CoreResponse> response, CoreLight light)
    : response_(std::move(response)), light_(std::move(light)) {}

void CoreSolver::solve(Progress& progress, const std::vector<Rgb>& start) {
    const std::size_t n = light_.diffuse.size();
    exitance_ = start.size() == n ? start : std::vector<Rgb>(n, Rgb(0.0f));
    std::vector<Rgb> source(n);
    float ratio = 0; // of one term of the series to the next
    for (std::size_t i = 0; i < n; ++i) {
        source[i] = light_.diffuse[i] + light_.direct[i] + light_.shellReflectance[i] * exitance_[i];
        ratio = std::max(ratio, maxComponent(light_.shellReflectance[i]) * response_->largestAlbedo());
    }
    for (iterations_ = 1; iterations_ <= kMaxIterations; ++iterations_) {
        progress.update("core", double(iterations_) / kMaxIterations);
        const std::vector<Rgb> next = response_->apply(source);
        float change = 0, largest = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3f d = next[i] - exitance_[i];
            change = std::max(change, std::max(std::abs(d.x), std::max(std::abs(d.y), std::abs(d.z))));
            largest = std::max(largest, maxComponent(next[i]));
            source[i] = light_.diffuse[i] + light_.direct[i] + light_.shellReflectance[i] * next[i];
        }
        exitance_ = next;
        // Stop where the rest of the geometric series is below 0.1 %.
        if (change <= kTolerance * (1 - std::min(ratio, 0.99f)) * largest) {
            break;
        }
    }
    sums_ = response_->itemSums(source);
}

} // namespace stf
