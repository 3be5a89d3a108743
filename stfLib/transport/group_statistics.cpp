// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/group_statistics.h"

namespace stf {

namespace {

// Sums over all values: of the squared sum over groups, and of the squares of each.
struct Sums {
    double squaredSum = 0, squares = 0;
    explicit Sums(const std::vector<std::vector<float>>& groups) {
        for (std::size_t i = 0; !groups.empty() && i < groups[0].size(); ++i) {
            double sum = 0;
            for (const std::vector<float>& g : groups) {
                sum += double(g[i]);
                squares += double(g[i]) * double(g[i]);
            }
            squaredSum += sum * sum;
        }
    }
};

} // namespace

double commonSquare(const std::vector<std::vector<float>>& groups) {
    if (groups.empty() || groups[0].empty()) {
        return 0;
    }
    // sum over g != h of a_g a_h = (sum a_g)^2 - sum a_g^2
    const Sums s(groups);
    const double count = double(groups.size());
    return (s.squaredSum - s.squares) / (count * (count - 1) * double(groups[0].size()));
}

double noiseSquare(const std::vector<std::vector<float>>& groups) {
    if (groups.empty() || groups[0].empty()) {
        return 0;
    }
    const Sums s(groups);
    const double count = double(groups.size());
    return (s.squares - s.squaredSum / count) / (count * (count - 1) * double(groups[0].size()));
}

} // namespace stf
