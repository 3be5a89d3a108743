// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/parallel.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace stf::test {

/// Mean of independent batches and the standard error of that mean.
struct Estimate {
    double mean = 0, sigma = 0;
};

inline Estimate estimate(const std::vector<double>& batches) {
    double sum = 0, squares = 0;
    const double n = double(batches.size());
    for (double b : batches) {
        sum += b;
    }
    for (double b : batches) {
        squares += (b - sum / n) * (b - sum / n);
    }
    return {sum / n, std::sqrt(squares / (n * (n - 1)))};
}

/// Runs make(batch) on all threads; the order of results is that of the numbers.
template<class Make>
auto runBatches(int count, Make make) {
    std::vector<decltype(make(0))> results{std::size_t(count)};
    parallelFor(std::size_t(count), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            results[b] = make(int(b));
        }
    });
    return results;
}

/// Estimate of a number that value(batch) takes from each batch.
template<class T, class Value>
Estimate estimate(const std::vector<T>& batches, Value value) {
    std::vector<double> numbers;
    for (const T& b : batches) {
        numbers.push_back(value(b));
    }
    return estimate(numbers);
}

/// Within 4 sigma of the expected value (plus a known systematic error), where sigma is small enough to tell a wrong
/// formula: at most `relative` of the expected value.
inline testing::AssertionResult agrees(const Estimate& e, double expected, double relative = 0.01,
                                       double systematic = 0) {
    const double difference = e.mean - expected;
    if (!(e.sigma <= relative * std::abs(expected))) {
        return testing::AssertionFailure()
               << "too noisy to tell: " << e.mean << " +- " << e.sigma << ", expected " << expected;
    }
    // Rounding of sums of doubles, for estimates without noise.
    if (!(std::abs(difference) <= 4 * e.sigma + systematic + 1e-9 * std::abs(expected))) {
        return testing::AssertionFailure()
               << e.mean << " +- " << e.sigma << " is " << difference / e.sigma << " sigma from " << expected;
    }
    return testing::AssertionSuccess();
}

} // namespace stf::test
