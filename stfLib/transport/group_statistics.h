// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace stf {

/// Mean over pairs of different groups of <a_g, a_h> / n: the squared rms of what the groups have in common, unbiased,
/// since the noise of one group knows nothing of another's. May be negative by noise. At least two groups.
double commonSquare(const std::vector<std::vector<float>>& groups);

/// Squared rms of the noise of the mean over groups: sum over g |a_g - mean|^2 / (G (G - 1) n).
double noiseSquare(const std::vector<std::vector<float>>& groups);

} // namespace stf
