// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/transform.h"

#include <vector>

namespace stf {

/// When light reaches the film, in the time of the scene's samples (frames, relative to the present one).
struct Shutter {
    double open = 0, close = 0;
    bool blurs() const { return close > open; }
    bool operator==(const Shutter& s) const { return open == s.open && close == s.close; }
};

/// Where something is at a time.
struct TransformSample {
    double time = 0;
    Transform transform;
    bool operator==(const TransformSample& s) const { return time == s.time && transform == s.transform; }
};

/// The way of something while the shutter is open: transforms at even steps from its opening to its closing, between
/// which every matrix element is linear in time (so does Embree, and both have to agree). Between samples, rotations
/// turn evenly (Shoemake and Duff 1992, "Matrix Animation and Polar Decomposition"), in steps of at most five degrees,
/// so that nothing that turns shrinks by more than 1/1000; before the first and after the last sample things stand
/// still. Empty where nothing moves: no samples, one, equal ones, a shutter that does not blur.
std::vector<Transform> motionSteps(std::vector<TransformSample> samples, const Shutter& shutter);

/// The transform at `time`, 0 (open) to 1 (closed), of steps that are not empty.
Transform atTime(const std::vector<Transform>& steps, float time);

} // namespace stf
