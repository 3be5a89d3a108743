// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/core/core_response.h"

#include <memory>
#include <vector>

namespace stf {

/// The light that arrives at the samples of an inner boundary. All arrays have one entry per sample.
struct CoreLight {
    std::vector<Rgb> diffuse;          ///< irradiance by light that has scattered in the shell
    std::vector<Rgb> direct;           ///< irradiance by light that has not, times R_c(mu) / R_cd of its incidence
    std::vector<Rgb> shellReflectance; ///< R_sd: what the shell sends back of the core's exitance

    explicit CoreLight(std::size_t samples = 0)
        : diffuse(samples, Rgb(0.0f)), direct(samples, Rgb(0.0f)), shellReflectance(samples, Rgb(0.0f)) {}
};

/// Exitance of the core, solving the balance between core and shell
///     B = K (E_t + R_sd B)                                                    (DESIGN 3.10)
/// with K the core's response.
class CoreSolver {
public:
    CoreSolver(std::shared_ptr<const CoreResponse> response, CoreLight light);

    /// Fixed point to a relative change of 0.1 %. `start`: an exitance to begin with, such as that under light that
    /// was nearly the same; empty: none. Throws Cancelled.
    void solve(Progress& progress, const std::vector<Rgb>& start = {});
    /// B at the samples.
    const std::vector<Rgb>& exitance() const { return exitance_; }
    /// Exitance by dipoles alone at any place (mm), after `solve`; see SampleTree::terms for `epsilon`.
    Rgb dipoleExitance(const Vec3f& place, float epsilon = CoreResponse::kEpsilon) const {
        return response_->dipoleExitance(place, sums_, epsilon);
    }
    int iterations() const { return iterations_; }

private:
    std::shared_ptr<const CoreResponse> response_;
    CoreLight light_;
    std::vector<Rgb> exitance_;
    std::vector<Rgb> sums_; ///< of E_t + R_sd B
    int iterations_ = 0;
};

} // namespace stf
