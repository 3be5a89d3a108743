// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/group_statistics.h"

namespace stf {

double commonSquare(const std::vector<std::vector<float>>& groups) {
    // sum over g != h of a_g a_h = (sum a_g)^2 - sum a_g^2
    const std::size_t n = groups.empty() ? 0 : groups[0].size();
    double total = 0;
    for (std::size_t i = 0; i < n; ++i) {
        double sum = 0, squares = 0;
        for (const std::vector<float>& g : groups) {
            sum += double(g[i]);
            squares += double(g[i]) * double(g[i]);
        }
        total += sum * sum - squares;
    }
    const double pairs = double(groups.size()) * double(groups.size() - 1);
    return n ? total / (pairs * double(n)) : 0.0;
}

double noiseSquare(const std::vector<std::vector<float>>& groups) {
    const std::size_t n = groups.empty() ? 0 : groups[0].size();
    double total = 0;
    for (std::size_t i = 0; i < n; ++i) {
        double sum = 0, squares = 0;
        for (const std::vector<float>& g : groups) {
            sum += double(g[i]);
            squares += double(g[i]) * double(g[i]);
        }
        total += squares - sum * sum / double(groups.size());
    }
    const double g = double(groups.size());
    return n ? total / (g * (g - 1) * double(n)) : 0.0;
}

} // namespace stf
