// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/column_response.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

struct TwoStream {
    double k, s;
};

TwoStream coefficients(double sigmaA, double sigmaSPrime) {
    return {2 * sigmaA, std::max(0.0, 0.75 * sigmaSPrime - 0.25 * sigmaA)};
}

/// Of a layer without end.
double reflectanceBelow(const TwoStream& c) {
    if (!(c.s > 0)) {
        return 0;
    }
    const double a = 1 + c.k / c.s;
    // a - sqrt(a^2 - 1), without its cancellation.
    return 1 / (a + std::sqrt(std::max(0.0, a * a - 1)));
}

} // namespace

double layerReflectance(double k, double s, double d, double below) {
    if (!(s * d > 1e-12)) {
        return below * std::exp(-2 * k * d);
    }
    const double a = 1 + k / s, b = std::sqrt(std::max(0.0, a * a - 1)), x = b * s * d;
    // b coth(x) goes to 1 / (s d) where nothing absorbs, and to b where the layer is thick.
    const double bCoth = x < 1e-4 ? 1 / (s * d) + b * x / 3 : b / std::tanh(x);
    return std::clamp((1 - below * (a - bCoth)) / (a - below + bCoth), 0.0, 1.0);
}

std::vector<Rgb> columnResponse(const BaseVolume& v) {
    std::vector<Rgb> out(std::size_t(v.size.x) * std::size_t(v.size.y));
    for (int y = 0; y < v.size.y; ++y) {
        for (int x = 0; x < v.size.x; ++x) {
            for (int c = 0; c < 3; ++c) {
                double r = reflectanceBelow(coefficients(v.coreSigmaA[c], v.coreSigmaSPrime[c]));
                for (int z = v.size.z; z-- > 0;) {
                    const std::size_t i = v.index(x, y, z);
                    // Voxels that hold material coefficients beside the surface are not material.
                    if (!v.surface.empty() && v.surface[i] > 0) {
                        continue;
                    }
                    const double kappa = double(v.extinction[i][c]), albedo = double(v.albedo[i][c]);
                    const double g = v.g.empty() ? 0 : double(v.g[i]);
                    const TwoStream t = coefficients(kappa * (1 - albedo), kappa * albedo * (1 - g));
                    r = layerReflectance(t.k, t.s, v.voxelMm.z, r);
                }
                out[std::size_t(y) * std::size_t(v.size.x) + std::size_t(x)][c] = float(r);
            }
        }
    }
    return out;
}

} // namespace stf
