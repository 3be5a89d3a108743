// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/gaussian_rank.h"

#include "stfLib/base/random.h"

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <numeric>

namespace stf {

double normalQuantile(double p) {
    return -std::sqrt(2.0) * boost::math::erfc_inv(2 * p);
}

std::vector<float> gaussianRanks(const std::vector<float>& values) {
    const std::size_t n = values.size();
    std::vector<std::uint32_t> order(n), tie(n);
    std::iota(order.begin(), order.end(), 0u);
    for (std::size_t i = 0; i < n; ++i) {
        tie[i] = CounterRng(0x72616e6b, i).bits();
    }
    std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
        return values[i] != values[j] ? values[i] < values[j] : tie[i] != tie[j] ? tie[i] < tie[j] : i < j;
    });
    std::vector<float> out(n);
    for (std::size_t rank = 0; rank < n; ++rank) {
        out[order[rank]] = float(normalQuantile((double(rank) + 0.5) / double(n)));
    }
    return out;
}

std::vector<float> gaussianQuantiles(std::vector<float> values, int count, float reach) {
    std::sort(values.begin(), values.end());
    std::vector<float> out;
    const double n = double(values.size());
    for (int k = 0; k < count && !values.empty(); ++k) {
        const double z = double(reach) * (2.0 * k / (count - 1) - 1);
        const double at = std::clamp(0.5 * std::erfc(-z / std::sqrt(2.0)) * n - 0.5, 0.0, n - 1);
        const std::size_t i = std::min(std::size_t(at), values.size() - 1), j = std::min(i + 1, values.size() - 1);
        out.push_back(float(double(values[i]) + (double(values[j]) - double(values[i])) * (at - double(i))));
    }
    return out;
}

} // namespace stf
