// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/core/dipole.h"

#include <vector>

namespace stf {

/// Points on the inner boundary and the light that arrives there. All arrays have one entry per point.
struct CoreSamples {
    std::vector<Vec3f> positions;      ///< mm
    std::vector<float> areas;          ///< mm^2
    std::vector<Rgb> diffuse;          ///< irradiance by light that has scattered in the shell
    std::vector<Rgb> direct;           ///< irradiance by light that has not, times R_c(mu) / R_cd of its incidence
    std::vector<Rgb> shellReflectance; ///< R_sd: what the shell sends back of the core's exitance
};

/// Exitance of the core, solving the balance between core and shell
///     B = K (E_t + R_sd B)                                                    (DESIGN 3.10)
/// with K the dipole, scaled so that uniform irradiance E gives exactly R_cd E at every point of any sampled surface.
/// A direct sum, O(n^2).
class CoreSolver {
public:
    CoreSolver(const CoreMaterial& material, CoreSamples samples);

    /// Fixed point to a relative change of 0.1 %. Throws Cancelled.
    void solve(Progress& progress);
    /// Exitance at any point (mm), after `solve`.
    Rgb exitance(const Vec3f& positionMm) const;
    int iterations() const { return iterations_; }

private:
    Rgb gather(const Vec3f& position) const;

    Dipole dipoles_[3];
    CoreSamples samples_;
    std::vector<Rgb> source_;      ///< E_t + R_sd B
    float soften2_[3] = {0, 0, 0}; ///< mm^2 added to squared distances, for the size of a sample
    int iterations_ = 0;
};

} // namespace stf
