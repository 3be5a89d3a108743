// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/multi_otsu.h"

#include "stfLib/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stf {

namespace {

// Sums over bins [0, b) of weight, weighted value and its square, about the middle of the range for the digits.
class Sums {
public:
    explicit Sums(const ValueHistogram& h) : origin_((h.lo + h.hi) / 2), n_(h.bins() + 1), x_(n_), xx_(n_) {
        weight_.resize(n_);
        for (std::size_t b = 0; b < h.bins(); ++b) {
            const double x = h.middle(b) - origin_, w = h.counts[b];
            weight_[b + 1] = weight_[b] + w;
            x_[b + 1] = x_[b] + w * x;
            xx_[b + 1] = xx_[b] + w * x * x;
        }
    }
    /// Sum of squared deviations from their mean of the values in bins [a, b).
    double spread(std::size_t a, std::size_t b) const {
        const double w = weight_[b] - weight_[a], x = x_[b] - x_[a];
        return w > 0 ? std::max(0.0, xx_[b] - xx_[a] - x * x / w) : 0.0;
    }
    double weight(std::size_t a, std::size_t b) const { return weight_[b] - weight_[a]; }
    double mean(std::size_t a, std::size_t b) const { return origin_ + (x_[b] - x_[a]) / weight(a, b); }

private:
    double origin_;
    std::size_t n_;
    std::vector<double> weight_, x_, xx_;
};

// Of rising values.
double weightedMedian(const std::vector<std::pair<double, double>>& values) {
    double total = 0, sum = 0;
    for (const auto& v : values) {
        total += v.second;
    }
    for (const auto& v : values) {
        sum += v.second;
        if (sum >= total / 2) {
            return v.first;
        }
    }
    return 0;
}

} // namespace

std::vector<double> otsuThresholds(const ValueHistogram& h, int k) {
    const std::size_t bins = h.bins();
    const std::size_t filled =
        std::size_t(std::count_if(h.counts.begin(), h.counts.end(), [](double c) { return c > 0; }));
    if (k < 2 || filled < std::size_t(std::max(0, k))) {
        throw Error(std::to_string(k) + " classes cannot be told apart by " + std::to_string(filled) +
                    " different values");
    }
    const Sums sums(h);
    // best[b]: least spread of the first bins [0, b) in the classes so far; from[c][b]: where the last of them begins.
    std::vector<double> best(bins + 1, std::numeric_limits<double>::infinity()), next(bins + 1);
    std::vector<std::vector<std::uint32_t>> from(std::size_t(k), std::vector<std::uint32_t>(bins + 1, 0));
    for (std::size_t b = 1; b <= bins; ++b) {
        if (sums.weight(0, b) > 0) {
            best[b] = sums.spread(0, b);
        }
    }
    for (int c = 1; c < k; ++c) {
        std::fill(next.begin(), next.end(), std::numeric_limits<double>::infinity());
        for (std::size_t b = std::size_t(c) + 1; b <= bins; ++b) {
            for (std::size_t a = std::size_t(c); a < b; ++a) {
                if (best[a] >= next[b] || !(sums.weight(a, b) > 0)) {
                    continue;
                }
                const double s = best[a] + sums.spread(a, b);
                if (s < next[b]) {
                    next[b] = s;
                    from[std::size_t(c)][b] = std::uint32_t(a);
                }
            }
        }
        best.swap(next);
    }
    std::vector<double> thresholds(std::size_t(k) - 1);
    std::size_t end = bins;
    for (int c = k - 1; c > 0; --c) {
        const std::size_t cut = from[std::size_t(c)][end];
        std::size_t lo = cut, hi = cut;
        while (lo > 0 && h.counts[lo - 1] == 0) {
            --lo;
        }
        while (hi < bins && h.counts[hi] == 0) {
            ++hi;
        }
        thresholds[std::size_t(c) - 1] = h.lo + (double(lo) + double(hi)) / 2 * h.width();
        end = cut;
    }
    return thresholds;
}

std::vector<ValueClass> classesBetween(const ValueHistogram& h, const std::vector<double>& thresholds) {
    const Sums sums(h);
    std::vector<ValueClass> classes;
    std::size_t begin = 0;
    const double total = h.total();
    for (std::size_t c = 0; c <= thresholds.size(); ++c) {
        std::size_t end = h.bins();
        if (c < thresholds.size()) {
            end = begin;
            while (end < h.bins() && h.middle(end) < thresholds[c]) {
                ++end;
            }
        }
        const double w = sums.weight(begin, end);
        if (w > 0) {
            classes.push_back({w / total, sums.mean(begin, end), std::sqrt(sums.spread(begin, end) / w)});
        } else {
            classes.push_back({0, (h.lo + h.hi) / 2, 0});
        }
        begin = end;
    }
    return classes;
}

std::vector<ValueClass> medianClasses(const ValueHistogram& h, const std::vector<double>& thresholds) {
    std::vector<ValueClass> classes = classesBetween(h, thresholds);
    std::size_t begin = 0;
    for (std::size_t c = 0; c < classes.size(); ++c) {
        std::vector<std::pair<double, double>> values; // with their weights
        while (begin < h.bins() && (c == thresholds.size() || h.middle(begin) < thresholds[c])) {
            values.emplace_back(h.middle(begin), h.counts[begin]);
            ++begin;
        }
        if (classes[c].share > 0) {
            classes[c].mean = weightedMedian(values);
            for (auto& v : values) {
                v.first = std::abs(v.first - classes[c].mean);
            }
            std::sort(values.begin(), values.end());
            classes[c].sigma = 1.4826 * weightedMedian(values);
        }
    }
    return classes;
}

} // namespace stf
