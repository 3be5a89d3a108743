// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/gauss_legendre.h"

#include <cmath>

namespace stf {

GaussLegendre::GaussLegendre(int n) : nodes(std::size_t(n)), weights(std::size_t(n)) {
    // Newton's method on the Legendre recurrence.
    for (int i = 0; i < n; ++i) {
        double z = std::cos(M_PI * (i + 0.75) / (n + 0.5)), derivative = 1;
        for (int iteration = 0; iteration < 100; ++iteration) {
            double p0 = 1, p1 = z;
            for (int k = 2; k <= n; ++k) {
                const double p2 = ((2 * k - 1) * z * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            derivative = n * (z * p1 - p0) / (z * z - 1);
            const double step = p1 / derivative;
            z -= step;
            if (std::abs(step) < 1e-15) {
                break;
            }
        }
        nodes[std::size_t(i)] = 0.5 * (1 - z);
        weights[std::size_t(i)] = 1 / ((1 - z * z) * derivative * derivative);
    }
}

} // namespace stf
