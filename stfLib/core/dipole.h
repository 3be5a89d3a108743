// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/optics/h_function.h"

#include <memory>

namespace stf {

/// Homogeneous core, index-matched to the shell's bottom. Coefficients in 1/mm, reduced scattering.
struct CoreMaterial {
    Vec3d sigmaA{0, 0, 0};
    Vec3d sigmaSPrime{0, 0, 0};
    /// False for a core that returns no light: nothing needs to be solved.
    bool scatters() const { return maxComponent(sigmaSPrime) > 0; }
    bool operator==(const CoreMaterial& m) const { return sigmaA == m.sigmaA && sigmaSPrime == m.sigmaSPrime; }
};

/// Classical dipole (Jensen et al. 2001) of one channel without a Fresnel boundary (A = 1). Used for the *shape* of
/// the response only: totals are the exact albedos of a semi-infinite isotropic medium (H function).
/// Limits: sigma_a = 0 decays as 1/r^3 and returns all light; sigma_s' = 0 returns none. Immutable, thread-safe.
class Dipole {
public:
    Dipole(double sigmaA, double sigmaSPrime);

    /// Radially symmetric kernel, 1/mm^2, at squared distance r2 (mm^2). Not normalised to the exact total.
    float kernel(float r2) const;
    /// Integral of `kernel` over a disc around the origin, closed form.
    double discIntegral(double radius) const;
    double planeIntegral() const;

    /// Exact albedo for diffuse light and for light at cosine mu.
    double diffuseAlbedo() const { return diffuseAlbedo_; }
    double directAlbedo(double mu) const { return black_ ? 0.0 : h_->reflectance(mu); }
    /// 1 / sigma_tr in mm; infinite without absorption.
    double diffusionLength() const;

private:
    bool black_ = false;
    float albedo_ = 0, transport_ = 0, zReal_ = 0, zVirtual_ = 0;
    double diffuseAlbedo_ = 0;
    std::shared_ptr<const HFunction> h_;
};

} // namespace stf
