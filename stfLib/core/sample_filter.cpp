// SPDX-License-Identifier: Apache-2.0
#include "stfLib/core/sample_filter.h"

#include "stfLib/base/parallel.h"

#include <algorithm>

namespace stf {

NearestSample::NearestSample(const SurfacePoints& samples, float reach)
    : samples_(samples), reach_(reach), cells_(samples.positions, 2 * reach) {}

std::uint32_t NearestSample::find(const Vec3f& place, const Vec3f& normal) const {
    float radius = reach_;
    for (int round = 0; round < 6; ++round, radius *= 2) {
        float least = radius * radius;
        std::size_t nearest = samples_.positions.size();
        cells_.near(place, radius, [&](std::size_t j) {
            const Vec3f d = samples_.positions[j] - place;
            const bool sameSide = round > 2 || samples_.normals.empty() || dot(samples_.normals[j], normal) > 0;
            if (sameSide && dot(d, d) < least) {
                least = dot(d, d);
                nearest = j;
            }
        });
        if (nearest < samples_.positions.size()) {
            return std::uint32_t(nearest);
        }
    }
    std::size_t nearest = 0;
    float least = 1e38f;
    for (std::size_t j = 0; j < samples_.positions.size(); ++j) {
        const Vec3f d = samples_.positions[j] - place;
        if (dot(d, d) < least) {
            least = dot(d, d);
            nearest = j;
        }
    }
    return std::uint32_t(nearest);
}

SampleFilter::SampleFilter(const SurfacePoints& samples, const std::vector<Vec3f>& places,
                           const std::vector<Vec3f>& normals, const std::vector<float>& radii) {
    constexpr std::size_t kGrain = 256;
    first_.assign(places.size() + 1, 0);
    if (places.empty() || samples.positions.empty()) {
        return;
    }
    double mean = 0;
    for (float r : radii) {
        mean += double(r) / double(radii.size());
    }
    const PointCells cells(samples.positions, float(mean));
    const NearestSample nearest(samples, float(mean));
    std::vector<std::vector<Term>> blocks((places.size() + kGrain - 1) / kGrain);
    parallelFor(places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<Term>& out = blocks[begin / kGrain];
        struct Found {
            float r2;
            Term term;
        };
        std::vector<Found> found;
        for (std::size_t i = begin; i < end; ++i) {
            float radius = radii[radii.size() == 1 ? 0 : i];
            const Vec3f normal = normals.empty() ? Vec3f(0.0f) : normals[i];
            found.clear();
            cells.near(places[i], radius, [&](std::size_t j) {
                const Vec3f d = samples.positions[j] - places[i];
                const float r2 = dot(d, d) / (radius * radius);
                const float facing =
                    samples.normals.empty() || normals.empty() ? 1.0f : dot(samples.normals[j], normal);
                if (r2 < 1 && facing > 0 && samples.areas[j] > 0) {
                    found.push_back({r2, {std::uint32_t(j), facing * samples.areas[j]}});
                }
            });
            float reach = 1; // of the radius
            if (found.size() > kMost) {
                std::nth_element(found.begin(), found.begin() + kMost, found.end(), [](const Found& a, const Found& b) {
                    return a.r2 != b.r2 ? a.r2 < b.r2 : a.term.sample < b.term.sample;
                });
                reach = found[kMost].r2; // squared; what is there has no weight left
                found.resize(kMost);
            }
            float sum = 0;
            for (Found& f : found) {
                const float left = 1 - f.r2 / reach;
                f.term.weight *= left * left;
                sum += f.term.weight;
            }
            if (!(sum > 0)) {
                found.assign(1, {0, {nearest.find(places[i], normal), 1}});
                sum = 1;
            }
            for (const Found& f : found) {
                out.push_back({f.term.sample, f.term.weight / sum});
            }
            first_[i + 1] = found.size();
        }
    });
    for (std::size_t i = 0; i < places.size(); ++i) {
        first_[i + 1] += first_[i];
    }
    terms_.reserve(first_.back());
    for (const std::vector<Term>& b : blocks) {
        terms_.insert(terms_.end(), b.begin(), b.end());
    }
}

Rgb SampleFilter::at(std::size_t place, const std::vector<Rgb>& samples) const {
    Rgb sum(0.0f);
    for (std::size_t k = first_[place]; k < first_[place + 1]; ++k) {
        sum += samples[terms_[k].sample] * terms_[k].weight;
    }
    return sum;
}

std::vector<Rgb> SampleFilter::apply(const std::vector<Rgb>& samples) const {
    std::vector<Rgb> out(count());
    parallelFor(out.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            out[i] = at(i, samples);
        }
    });
    return out;
}

} // namespace stf
