// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"

#include <complex>
#include <vector>

namespace stf {

/// A quadratic energy of one complex number per vertex of a graph: the sum over links of w |z_i - r_ij z_j|^2, with a
/// rotation r_ij from j to i, and over vertices of d_i |z_i|^2 - 2 Re(conj(b_i) z_i).
struct ConnectionEnergy {
    std::vector<int> first, neighbour;        ///< as in SurfaceGraph
    std::vector<std::complex<float>> link;    ///< w r_ij, at i's link to j; the one back is its conjugate
    std::vector<double> diagonal;             ///< per vertex: sum of w of its links, and d
    std::vector<double> mass;                 ///< area
    std::vector<std::complex<double>> wanted; ///< b; empty: none

    std::size_t size() const { return diagonal.size(); }
};

/// Where the energy is least; without `wanted`, the eigenvector of the smallest eigenvalue of each component, of norm 1
/// by mass. By a sparse Cholesky factor on an algebraic hierarchy of merged vertices (Galerkin: the coarse problem is
/// the fine one, for fields constant on each cluster but for the rotations), smoothed from level to level: linear in
/// the number of vertices; smooth answers come out exactly enough for what they are used for, not to rounding.
/// Deterministic for any number of threads. Throws Error where there is no answer.
std::vector<std::complex<double>> minimize(ConnectionEnergy energy, const char* stage, Progress& progress);

} // namespace stf
