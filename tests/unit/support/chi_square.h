// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/unit/support/statistics.h"

#include <cstdio>

namespace stf::test {

/// Sum of squared deviations in units of their standard errors over many comparisons, with the spread it should have.
/// What one run of walks gives several numbers of is added as a group: numbers of a group may be correlated.
class ChiSquare {
public:
    /// `batches[k][b]` is quantity k in batch b. Quantities without noise or without a place in a test are left out by
    /// the caller.
    void add(const std::vector<std::vector<double>>& batches, const std::vector<double>& expected) {
        for (std::size_t k = 0; k < batches.size(); ++k) {
            const Estimate e = estimate(batches[k]);
            const double z = (e.mean - expected[k]) / e.sigma, nu = double(batches[k].size()) - 1;
            sum_ += z * z;
            worst_ = std::max(worst_, std::abs(z));
            // z has Student's distribution of nu degrees: mean of z^2 and, with itself, its variance.
            mean_ += nu / (nu - 2);
            ++count_;
            for (std::size_t j = 0; j < batches.size(); ++j) {
                // Squares of normal numbers with correlation rho have covariance 2 rho^2.
                const double rho = correlation(batches[k], batches[j]);
                variance_ += 2 * rho * rho * (nu * nu * (nu - 1) / ((nu - 2) * (nu - 2) * (nu - 4)));
            }
        }
    }
    /// Within 4 sigma of what it should be; tells the numbers either way.
    testing::AssertionResult holds(const char* name) const {
        const double z = (sum_ - mean_) / std::sqrt(variance_);
        char text[200];
        std::snprintf(text, sizeof text, "%s: chi-square %.1f over %d comparisons (%+.2f sigma), worst %.2f sigma",
                      name, sum_, count_, z, worst_);
        std::printf("             %s\n", text);
        return count_ > 0 && std::abs(z) <= 4 ? testing::AssertionSuccess() << text
                                              : testing::AssertionFailure() << text;
    }
    int count() const { return count_; }

private:
    static double correlation(const std::vector<double>& a, const std::vector<double>& b) {
        const Estimate ea = estimate(a), eb = estimate(b);
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            sum += (a[i] - ea.mean) * (b[i] - eb.mean);
        }
        const double n = double(a.size());
        return sum / (n * (n - 1) * ea.sigma * eb.sigma);
    }
    double sum_ = 0, mean_ = 0, variance_ = 0, worst_ = 0;
    int count_ = 0;
};

} // namespace stf::test
