// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/fresnel.h"

#include "stfLib/optics/gauss_legendre.h"

namespace stf {

namespace {

// F_ext, with nMinus1 = n - 1 > 0 given as such. In a = (g - c) / (g + c) Fresnel's equations are rational:
//   R = a^2 (1 + q^2) / 2,  c (g - c) = k (1 - a) / 2,  c (g + c) = k (1/a - 1) / 2,  k = n^2 - 1,
//   2 c dc = k/4 (1 - 1/a^2) da,  from a = 1 at grazing to (n - 1) / (n + 1) at normal incidence.
// With a = exp(-u) the integrand is smooth at every scale: k/8 INT (1 - a^2) (1 + q^2) a du.
double external(double nMinus1) {
    const GaussLegendre rule(48);
    constexpr int kPieces = 8;
    const double k = nMinus1 * (nMinus1 + 2), end = std::log1p(2 / nMinus1);
    double sum = 0;
    for (int piece = 0; piece < kPieces; ++piece) {
        for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
            const double u = end * (piece + rule.nodes[i]) / kPieces, a = std::exp(-u), oneMinusA = -std::expm1(-u);
            const double q = (0.5 * k * oneMinusA / a - 1) / (0.5 * k * oneMinusA + 1);
            sum += rule.weights[i] * oneMinusA * (1 + a) * (1 + q * q) * a;
        }
    }
    return k / 8 * sum * end / kPieces;
}

} // namespace

double diffuseFresnel(double eta) {
    if (eta == 1) {
        return 0;
    }
    if (eta > 1) {
        return external(eta - 1);
    }
    const double nMinus1 = (1 - eta) / eta, k = nMinus1 * (nMinus1 + 2);
    return (k + external(nMinus1)) * eta * eta;
}

} // namespace stf
