// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/progress.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/base_volume.h"

namespace stf {

struct TransportOptions {
    float quality = 0.02f; ///< wanted relative noise of the tables, after the renderer's lookup filter
    std::uint64_t seed = 0;
    std::uint64_t maxPhotons =
        1'500'000;    ///< per direction and channel; reported where it keeps the noise above the target
    int polars = 7;   ///< polar nodes below 90 degrees
    int azimuths = 0; ///< 0: six where there is relief, else one (averaged over azimuth)
    bool filter = true; ///< lateral filter against noise; off to measure its bias

    /// Names these options and the version of the algorithm; with the volume's hash, the key of a cached table.
    std::string key() const;
};

/// Computes the table of a volume by walks through the periodic tile: I_m and bottom irradiance for every direction,
/// backlight and reflectance from below. The result does not depend on the number of threads. Progress is in photons.
/// Throws Cancelled.
StfTable precompute(const BaseVolume& volume, const TransportOptions& options, Progress& progress,
                    const MessageSink& messages);

} // namespace stf
