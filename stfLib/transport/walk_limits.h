// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// What all ways of walking share.
namespace stf::walk_limits {

/// Below this weight roulette decides.
constexpr double kRouletteBelow = 0.1, kRouletteTo = 0.3;
/// A walk that met this many interfaces between two collisions is trapped: by total reflection where nothing scatters,
/// or in a corner of the interpolated surface.
constexpr int kMaxSurfaces = 100'000;

/// Key of the random numbers of a source.
inline std::uint64_t streamKey(std::uint64_t seed, std::uint64_t source) {
    return seed + 0x9e3779b97f4a7c15ull * (source + 1);
}

} // namespace stf::walk_limits
