// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/h_function.h"

#include <algorithm>
#include <cmath>

namespace stf {

namespace {

// Gauss-Legendre on [0, 1] by Newton's method on the Legendre recurrence.
void gaussLegendre(int n, std::vector<double>& x, std::vector<double>& w) {
    x.resize(std::size_t(n));
    w.resize(std::size_t(n));
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
        x[std::size_t(i)] = 0.5 * (1 - z);
        w[std::size_t(i)] = 1 / ((1 - z * z) * derivative * derivative);
    }
}

} // namespace

HFunction::HFunction(double absorption)
    : albedo_(1 - std::clamp(absorption, 0.0, 1.0)), rootAbsorption_(std::sqrt(std::clamp(absorption, 0.0, 1.0))) {
    // mu = t^2 takes the logarithmic slope of H at grazing angles out of the integrand.
    std::vector<double> t, wt;
    gaussLegendre(64, t, wt);
    for (std::size_t i = 0; i < t.size(); ++i) {
        nodes_.push_back(t[i] * t[i]);
        weights_.push_back(2 * t[i] * wt[i]);
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
