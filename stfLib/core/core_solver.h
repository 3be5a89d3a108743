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
/// The balance is a direct sum, O(n^2). Elsewhere exitance is gathered from clusters: one whose radius is small
/// against its distance counts as one point at its centre of area (Jensen & Buhler 2002).
class CoreSolver {
public:
    CoreSolver(const CoreMaterial& material, CoreSamples samples);

    /// Fixed point to a relative change of 0.1 %. Throws Cancelled.
    void solve(Progress& progress);
    /// Exitance at any point (mm), after `solve`. `opening`: largest radius of a cluster over its distance.
    Rgb exitance(const Vec3f& positionMm, float opening = 0.25f) const;
    int iterations() const { return iterations_; }

private:
    /// Neighbouring samples: flux and area are exact sums, so totals do not depend on the clustering.
    struct Cluster {
        Vec3f centre;
        float radius = 0, area = 0;
        Rgb flux{0.0f}; ///< sum of area * source
        std::size_t first = 0, count = 0;
    };
    void buildClusters();

    Dipole dipoles_[3];
    CoreSamples samples_;
    std::vector<Rgb> source_; ///< E_t + R_sd B
    std::vector<Cluster> clusters_;
    std::vector<std::size_t> order_; ///< samples by cluster
    float soften2_[3] = {0, 0, 0}; ///< mm^2 added to squared distances, for the size of a sample
    int iterations_ = 0;
};

} // namespace stf
