// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/core_light.h"
#include "stfLib/render/light_gather.h"

namespace stf {

/// The light that shells, their cores, and the surfaces around them give each other, as far as it does not depend on
/// the camera: what shells get from plain surfaces and from shells, what leaves them, and what leaves their cores.
/// Found by turns until it changes no more. Keeps what lights do not change, for the next edit. One thread at a time.
class LightBalance {
public:
    struct Report {
        int cores = 0;           ///< solved
        std::string core;        ///< of the first
        double coreSeconds = 0;  ///< responses, lights and first solution
        std::size_t gathers = 0; ///< shells that looked for light of other surfaces
        std::size_t samples = 0; ///< of their surfaces
        int raysPerSample = 0;
        double shellShare = 0; ///< of these rays met shells
        int rounds = 0;        ///< of light between shells
        double lastChange = 0; ///< of all light that leaves shells, in the last round
        double indirectSeconds = 0;
    };
    /// Fills `core`, `indirect` and `exitant` of the scene's instances. `bounces`: light of other surfaces counts.
    /// Deterministic by `seed`. Throws Cancelled.
    Report solve(PreparedScene& scene, bool bounces, std::uint64_t seed, Progress& progress);

private:
    ShellCores cores_;
    StageCache<SurfaceSampling> samplings_;
};

} // namespace stf
