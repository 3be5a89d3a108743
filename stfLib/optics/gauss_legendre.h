// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace stf {

/// Nodes and weights of Gauss-Legendre quadrature on [0, 1]: exact for polynomials up to degree 2 n - 1.
struct GaussLegendre {
    explicit GaussLegendre(int n);
    std::vector<double> nodes, weights;
};

} // namespace stf
