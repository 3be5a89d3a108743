// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/error.h"
#include "stfLib/base/progress.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/base_volume.h"

namespace stf {

struct TransportOptions {
    /// Wanted relative error of the table as it is read: root mean square over voxels and directions (TableError).
    float quality = 0.02f;
    std::uint64_t seed = 0;
    TransportForm form = TransportForm::DE1;
    bool openBottom = false; ///< the bottom is an interface to outside too, for slabs without a core
    /// Photons of the whole table and channel; reported where it keeps the error above the target.
    std::uint64_t maxPhotons = 150'000'000;
    int polars = 0;              ///< polar nodes below 90 degrees; 0: chosen
    int azimuths = 0;            ///< azimuths of each ring, 1 or even; 0: chosen
    bool fineDirections = false; ///< enough for a quarter of the error that directions may make
    bool filter = true;          ///< lateral filter against noise, as wide as its bias allows

    /// Names these options and the version of the algorithm; with the volume's hash, the key of a cached table.
    std::string key() const;
};

/// Computes the table of a volume by walks through the periodic tile. Directions, filter, rank and photons are chosen
/// from the wanted error by pilot walks, and walks go on until the estimated error is met. The result does not depend
/// on the number of threads. Progress is the share of the photons. Throws Error on bad volumes, Cancelled.
StfTable precompute(const BaseVolume& volume, const TransportOptions& options, Progress& progress,
                    const MessageSink& messages);

} // namespace stf
