// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/gaussian_mixture.h"

#include "stfLib/acquire/multi_otsu.h"

#include <algorithm>
#include <cmath>

namespace stf {

std::vector<ValueClass> fitGaussianMixture(const ValueHistogram& h, int k) {
    std::vector<ValueClass> classes = classesBetween(h, otsuThresholds(h, k));
    const double narrowest = std::max(h.width(), (h.hi - h.lo) / 200), total = h.total();
    for (ValueClass& c : classes) {
        c.sigma = std::max(c.sigma, narrowest);
    }
    constexpr int kMostSteps = 2000;
    double before = -1e300, shared = 0.05; // share of voxels between the classes
    std::vector<double> part(classes.size());
    for (int step = 0; step < kMostSteps; ++step) {
        std::vector<ValueClass> sums(classes.size()); // share, and in mean and sigma the first and second moments
        double likelihood = 0, sharedSum = 0;
        double lowest = classes[0].mean, highest = lowest;
        for (const ValueClass& c : classes) {
            lowest = std::min(lowest, c.mean);
            highest = std::max(highest, c.mean);
        }
        // As a Gaussian's density without its 1 / sqrt(2 pi).
        const double level = highest > lowest ? shared * std::sqrt(2 * M_PI) / (highest - lowest) : 0;
        for (std::size_t b = 0; b < h.bins(); ++b) {
            if (h.counts[b] == 0) {
                continue;
            }
            const double x = h.middle(b);
            const double between = x > lowest && x < highest ? level : 0;
            double sum = between;
            for (std::size_t c = 0; c < classes.size(); ++c) {
                const double z = (x - classes[c].mean) / classes[c].sigma;
                // A floor of e^-350 keeps the sum above zero far from every mean; the nearest class takes the value.
                part[c] = classes[c].share / classes[c].sigma * std::exp(-std::min(0.5 * z * z, 350.0));
                sum += part[c];
            }
            sum = std::max(sum, 1e-300);
            likelihood += h.counts[b] * std::log(sum);
            sharedSum += h.counts[b] * between / sum;
            for (std::size_t c = 0; c < classes.size(); ++c) {
                const double w = h.counts[b] * part[c] / sum, d = x - classes[c].mean;
                sums[c].share += w;
                sums[c].mean += w * d;
                sums[c].sigma += w * d * d;
            }
        }
        for (std::size_t c = 0; c < classes.size(); ++c) {
            const double w = sums[c].share;
            if (!(w > 1e-12 * total)) {
                continue; // a class without values stays where it is
            }
            const double shift = sums[c].mean / w;
            classes[c].share = w / total;
            classes[c].mean += shift;
            classes[c].sigma = std::max(narrowest, std::sqrt(std::max(0.0, sums[c].sigma / w - shift * shift)));
        }
        shared = sharedSum / total;
        likelihood /= total;
        if (likelihood - before < 1e-9 && step > 0) {
            break;
        }
        before = likelihood;
    }
    double sum = 0;
    for (const ValueClass& c : classes) {
        sum += c.share;
    }
    for (ValueClass& c : classes) {
        c.share /= sum;
    }
    std::sort(classes.begin(), classes.end(), [](const ValueClass& a, const ValueClass& b) { return a.mean < b.mean; });
    return classes;
}

} // namespace stf
