// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/h_function.h"

#include "stfLib/optics/gauss_legendre.h"

#include <algorithm>
#include <cmath>

namespace stf {

HFunction::HFunction(double absorption)
    : albedo_(1 - std::clamp(absorption, 0.0, 1.0)), rootAbsorption_(std::sqrt(std::clamp(absorption, 0.0, 1.0))) {
    // mu = t^2 takes the logarithmic slope of H at grazing angles out of the integrand.
    const GaussLegendre rule(64);
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double t = rule.nodes[i];
        nodes_.push_back(t * t);
        weights_.push_back(2 * t * rule.weights[i]);
    }
    // 1/H(mu) = sqrt(1-a) + (a/2) INT mu' H(mu') / (mu + mu') dmu'. Averaging two iterates makes it converge at a = 1.
    values_.assign(nodes_.size(), 1.0);
    std::vector<double> next(nodes_.size());
    for (int iteration = 0; iteration < 2000; ++iteration) {
        double change = 0;
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            next[i] = (*this)(nodes_[i]);
        }
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const double v = 0.5 * (values_[i] + next[i]);
            change = std::max(change, std::abs(v - values_[i]) / v);
            values_[i] = v;
        }
        if (change < 1e-13) {
            break;
        }
    }
}

double HFunction::operator()(double mu) const {
    double sum = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        sum += weights_[i] * nodes_[i] * values_[i] / (mu + nodes_[i]);
    }
    return 1 / (rootAbsorption_ + 0.5 * albedo_ * sum);
}

double HFunction::reflectance(double mu) const {
    return 1 - rootAbsorption_ * (*this)(mu);
}

double HFunction::diffuseReflectance() const {
    double moment = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        moment += weights_[i] * nodes_[i] * values_[i];
    }
    return 1 - 2 * rootAbsorption_ * moment;
}

} // namespace stf
