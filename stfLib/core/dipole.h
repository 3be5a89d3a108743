// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/optics/h_function.h"

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

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
    /// The same from a table, several times as fast; relative error below 0.3 % down to 1e-4 of the kernel's peak, 2 %
    /// to 1e-12 (tests/unit/core).
    float tabulated(float r2) const {
        if (black_) {
            return 0;
        }
        const float clamped = std::min(std::max(r2, lowestR2_), highestR2_);
        std::uint32_t bits = 0;
        std::memcpy(&bits, &clamped, sizeof bits);
        const float* const entry = table_->data() + ((bits >> kFractionBits) - firstEntry_);
        const float fraction = float(bits & ((1u << kFractionBits) - 1)) * (1.0f / float(1u << kFractionBits));
        return entry[0] + (entry[1] - entry[0]) * fraction;
    }
    /// Integral of `kernel` over a disc around the origin, closed form.
    double discIntegral(double radius) const;
    double planeIntegral() const;

    /// Exact albedo for diffuse light and for light at cosine mu.
    double diffuseAlbedo() const { return diffuseAlbedo_; }
    double directAlbedo(double mu) const { return black_ ? 0.0 : h_->reflectance(mu); }
    /// 1 / sigma_tr in mm; infinite without absorption.
    double diffusionLength() const;

private:
    // The table is linear within 1/32 of an octave of r2: its index is the top of the float's own bits.
    static constexpr int kFractionBits = 18;
    static constexpr float kLowest = 0x1p-20f, kHighest = 0x1p40f; ///< of r2 in about squared mean free paths

    bool black_ = false;
    std::uint32_t firstEntry_ = 0;
    float lowestR2_ = kLowest, highestR2_ = kHighest; ///< mm^2, of the table
    float albedo_ = 0, transport_ = 0, zReal_ = 0, zVirtual_ = 0;
    double diffuseAlbedo_ = 0;
    std::shared_ptr<const HFunction> h_;
    std::shared_ptr<const std::vector<float>> table_; ///< kernel at the values of r2 whose low mantissa bits are zero
};

} // namespace stf
