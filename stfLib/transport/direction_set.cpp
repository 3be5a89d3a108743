// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/direction_set.h"

#include "stfLib/optics/fresnel.h"

namespace stf {

namespace {

constexpr float kPi = 3.14159265358979f;

// Lagrange's basis polynomials of the nodes 0, 1, 2, 3 at x.
void cubic(float x, float (&weight)[4]) {
    const float a = x, b = x - 1, c = x - 2, d = x - 3;
    weight[0] = -b * c * d / 6;
    weight[1] = a * c * d / 2;
    weight[2] = -a * b * d / 2;
    weight[3] = a * b * c / 6;
}

// Nodes around a ring and their weights.
struct Around {
    int node[4];
    float weight[4];
    int count;
};

Around around(float phi, int azimuths) {
    if (azimuths == 1) {
        return {{0}, {1}, 1};
    }
    float x = phi / (2 * kPi) * float(azimuths);
    x -= std::floor(x / float(azimuths)) * float(azimuths);
    const int lower = std::min(int(x), azimuths - 1);
    if (azimuths == 2) {
        return {{lower, 1 - lower}, {1 - (x - float(lower)), x - float(lower)}, 2};
    }
    Around a{{}, {}, 4};
    cubic(x - float(lower) + 1, a.weight);
    for (int i = 0; i < 4; ++i) {
        a.node[i] = (lower - 1 + i + azimuths) % azimuths;
    }
    return a;
}

} // namespace

DirectionSet::DirectionSet(int polars, int azimuths, float topIor)
    : polars_(std::max(1, polars)), azimuths_(azimuths <= 1 ? 1 : azimuths + azimuths % 2),
      step_(0.5f * kPi / float(polars_)), topIor_(topIor) {
    for (int i = 0; i < polars_ && topIor != 1; ++i) {
        entering_.push_back(1 - fresnelReflectance(std::cos(float(i) * step_), topIor));
    }
}

Vec3f DirectionSet::direction(int index) const {
    if (index == 0) {
        return {0, 0, 1};
    }
    const float theta = polarAngle(index), phi = 2 * kPi * float((index - 1) % azimuths_) / float(azimuths_);
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

DirectionWeights DirectionSet::weights(const Vec3f& w) const {
    DirectionWeights result;
    // atan2 keeps its precision near the pole, acos does not.
    const float theta = std::atan2(std::sqrt(w.x * w.x + w.y * w.y), w.z) / step_;
    if (polars_ == 0 || !(w.z > 0) || !(theta >= 0)) {
        return result;
    }
    const float entering = entering_.empty() ? 1.0f : 1 - fresnelReflectance(w.z, topIor_);
    if (polars_ == 1) {
        if (theta < 1) {
            result.index[0] = 0;
            result.weight[0] = (1 - theta) * (entering_.empty() ? 1.0f : entering / entering_[0]);
            result.count = 1;
        }
        return result;
    }
    // Rings base to base + 3; those below 0 lie on the other side of the pole, ring `polars` at 90 degrees holds zero.
    const int base = std::min(int(theta) - 1, polars_ - 3);
    float ringWeight[4];
    cubic(theta - float(base), ringWeight);
    const Around nodes = around(std::atan2(w.y, w.x), azimuths_);
    const auto add = [&](int index, float weight) {
        if (weight != 0) {
            result.index[result.count] = index;
            result.weight[result.count++] = weight;
        }
    };
    for (int i = 3; i >= 0; --i) { // the other side last
        const int ring = base + i;
        if (ring == polars_) {
            continue;
        }
        if (!entering_.empty()) {
            ringWeight[i] *= entering / entering_[std::size_t(std::abs(ring))];
        }
        if (ring == 0) {
            add(0, ringWeight[i]);
            continue;
        }
        const int first = result.count;
        for (int k = 0; k < nodes.count; ++k) {
            const int azimuth = ring > 0 ? nodes.node[k] : (nodes.node[k] + azimuths_ / 2) % azimuths_;
            add(1 + (std::abs(ring) - 1) * azimuths_ + azimuth, ringWeight[i] * nodes.weight[k]);
        }
        if (ring < 0) {
            result.across += result.count - first;
        }
    }
    return result;
}

} // namespace stf
