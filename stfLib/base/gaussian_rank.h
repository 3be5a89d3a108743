// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace stf {

/// Values in place of which the normal quantiles of their ranks stand: N(0, 1) whatever the distribution was. Equal
/// values are ranked in an order that depends on their place in the list, scattered evenly.
std::vector<float> gaussianRanks(const std::vector<float>& values);

/// What undoes it: quantiles of the values at `count` even steps of a Gaussian variable from -reach to reach.
std::vector<float> gaussianQuantiles(std::vector<float> values, int count, float reach);

/// Inverse of the standard normal distribution function, 0 < p < 1.
double normalQuantile(double p);

} // namespace stf
