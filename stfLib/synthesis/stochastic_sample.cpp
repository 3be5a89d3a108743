// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/stochastic_sample.h"

#include "stfLib/base/gaussian_rank.h"
#include "stfLib/synthesis/column_response.h"
#include "stfLib/transport/lateral_filter.h"

#include <cmath>
#include <cstdio>

namespace stf {

namespace {

constexpr double kTolerance = 0.5;
constexpr double kLeastPlaces = 100;
constexpr double kLeastShare = 0.01; ///< of the variance: less than that in a band is not seen

double excessKurtosis(const std::vector<Rgb>& fine, const std::vector<Rgb>& coarse) {
    const double n = double(fine.size());
    double mean = 0, second = 0, fourth = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
        mean += double(fine[i].x - coarse[i].x) / n;
    }
    for (std::size_t i = 0; i < fine.size(); ++i) {
        const double d = double(fine[i].x - coarse[i].x) - mean;
        second += d * d / n;
        fourth += d * d * d * d / n;
    }
    return second > kLeastShare ? fourth / (second * second) - 3 : 0.0;
}

} // namespace

Randomness judgeRandomness(const BaseVolume& v) {
    Randomness out;
    if (v.hasRelief()) {
        out.why = "the top is a relief";
        return out;
    }
    if (!v.emission.empty()) {
        out.why = "some emits light";
        return out;
    }
    const std::size_t columns = std::size_t(v.size.x) * std::size_t(v.size.y);
    std::vector<float> response, extinction(columns, 0.0f);
    for (const Rgb& r : columnResponse(v)) {
        response.push_back(average(r));
    }
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        extinction[i % columns] += average(v.extinction[i]);
    }
    const double texel = std::min(v.voxelMm.x, v.voxelMm.y);
    const double areaTexels = v.extentMm().x * v.extentMm().y / (texel * texel);
    const Vec3i flat{v.size.x, v.size.y, 1};
    out.stochastic = true;
    int bands = 0;
    for (const std::vector<float>* image : {&response, &extinction}) {
        std::vector<Rgb> fine;
        for (float g : gaussianRanks(*image)) {
            fine.push_back(Rgb(g));
        }
        for (double sigma = 0.7;; sigma *= 2) {
            // Places that a filter of this width sees apart.
            const double places = areaTexels / (4 * 3.14159265358979 * sigma * sigma);
            if (places < kLeastPlaces) {
                break;
            }
            std::vector<Rgb> coarse = fine;
            LateralFilter(flat, v.voxelMm, sigma * texel).apply(coarse);
            const double excess = excessKurtosis(fine, coarse);
            if (std::abs(excess) > std::abs(out.excessKurtosis)) {
                out.excessKurtosis = excess;
            }
            out.stochastic = out.stochastic && std::abs(excess) <= kTolerance + 3 * std::sqrt(24 / places);
            fine = std::move(coarse);
            ++bands;
        }
    }
    char text[120];
    if (bands == 0) {
        out.stochastic = false;
        out.why = "there is too little to judge";
    } else {
        std::snprintf(text, sizeof text, "columns are %s (excess kurtosis %.2g)",
                      out.stochastic ? "random" : "structured", out.excessKurtosis);
        out.why = text;
    }
    return out;
}

} // namespace stf
