// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/direction_set.h"

namespace stf {

namespace {
constexpr float kPi = 3.14159265358979f;
}

DirectionSet::DirectionSet(int polars, int azimuths)
    : polars_(std::max(1, polars)), azimuths_(std::max(1, azimuths)), step_(0.5f * kPi / float(std::max(1, polars))) {}

Vec3f DirectionSet::direction(int index) const {
    const float theta = polarAngle(index), phi = 2 * kPi * float(index % azimuths_) / float(azimuths_);
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

DirectionWeights DirectionSet::weights(const Vec3f& w) const {
    DirectionWeights result;
    if (!(w.z > 0)) {
        return result;
    }
    // atan2 keeps its precision near the pole, acos does not.
    const float theta = std::atan2(std::sqrt(w.x * w.x + w.y * w.y), w.z) / step_;
    const int lower = std::min(int(theta), polars_ - 1);
    const float fraction = std::min(1.0f, theta - float(lower));
    int a0 = 0, a1 = 0;
    float around = 0;
    if (azimuths_ > 1) {
        float phi = std::atan2(w.y, w.x) / (2 * kPi) * float(azimuths_);
        phi -= std::floor(phi / float(azimuths_)) * float(azimuths_);
        a0 = std::min(int(phi), azimuths_ - 1);
        around = phi - float(a0);
        a1 = (a0 + 1) % azimuths_;
    }
    const auto add = [&](int polar, int azimuth, float weight) {
        if (polar < polars_ && weight > 0) {
            result.index[result.count] = polar * azimuths_ + azimuth;
            result.weight[result.count++] = weight;
        }
    };
    add(lower, a0, (1 - fraction) * (1 - around));
    add(lower, a1, (1 - fraction) * around);
    add(lower + 1, a0, fraction * (1 - around));
    add(lower + 1, a1, fraction * around);
    return result;
}

} // namespace stf
