// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/base/gf/vec3f.h"

#include <cstdint>
#include <initializer_list>
#include <random>
#include <vector>

namespace fuzz {

/// Numbers of one edit, from its own seed: an edit does the same whichever others are left out.
class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}

    std::uint64_t bits() { return engine_(); }
    int below(int count) { return int(engine_() % std::uint64_t(count)); }
    bool chance(double p) { return double(engine_() >> 11) * 0x1p-53 < p; }
    /// From a coarse grid, so that values come back to what they were.
    float between(float low, float high) { return low + (high - low) * float(below(17)) / 16; }
    PXR_NS::GfVec3f vec(float low, float high) {
        const float x = between(low, high), y = between(low, high);
        return {x, y, between(low, high)};
    }
    template<class T>
    T of(std::initializer_list<T> values) {
        return values.begin()[below(int(values.size()))];
    }
    template<class T>
    const T& of(const std::vector<T>& values) {
        return values[std::size_t(below(int(values.size())))];
    }

private:
    std::mt19937_64 engine_;
};

} // namespace fuzz
