// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"
#include "stfLib/optics/material.h"

namespace stf {

/// Reflectance of a semi-infinite medium of isotropic scattering under a smooth interface, exact: Chandrasekhar's
/// reflection function (H functions) for what the medium returns, coupled with Fresnel's reflectance from within at
/// every angle. For light at normal incidence, as a share of the flux that entered (the external reflection is left
/// out, as in the R_d of Jensen et al. 2001). `absorption` = 1 - albedo, 0 to 1; `ior` relative to outside, 0.1 to 10.
/// Absolute error below 2e-6 (tests/unit/optics).
double semiInfiniteReflectance(double absorption, double ior);

/// The same per channel of a material, by similarity: isotropic scattering with sigma_s'. 0 where nothing scatters.
Vec3d diffuseReflectance(const Material& material);
/// Mean free path of diffusing light, 1 / (sigma_a + sigma_s'), mm; infinite in a void.
Vec3d meanFreePathMm(const Material& material);
/// Diffusion length 1 / sigma_tr with sigma_tr^2 = 3 sigma_a (sigma_a + sigma_s'), mm; infinite without absorption.
Vec3d diffusionLengthMm(const Material& material);

} // namespace stf
