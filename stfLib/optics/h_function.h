// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace stf {

/// Chandrasekhar's H function of isotropic scattering (Radiative Transfer, 1960, chapter V): the exact reflectance of a
/// semi-infinite, index-matched medium. Relative error below 1e-6 for albedo 0 to 1 (tests/unit/optics).
class HFunction {
public:
    /// `absorption` = 1 - albedo, given as such because it may be tiny.
    explicit HFunction(double absorption);

    double operator()(double mu) const;
    /// Reflectance for light at cosine mu: 1 - sqrt(1 - a) H(mu).
    double reflectance(double mu) const;
    /// Reflectance for diffuse light (spherical albedo): 1 - 2 sqrt(1 - a) INT H(mu) mu dmu.
    double diffuseReflectance() const;

private:
    double albedo_, rootAbsorption_;
    std::vector<double> nodes_, weights_, values_;
};

} // namespace stf
