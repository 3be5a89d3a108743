// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"
#include "stfLib/volume/volume_statistics.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace stf {

/// What `stf inspect` prints of a base volume. Infinities are null.
nlohmann::json describeVolume(const BaseVolume& volume, const VolumeStatistics& statistics);
/// What its maker should know, a sentence each: a shell too thin for its diffusion length, a seam, empty columns.
std::vector<std::string> volumeWarnings(const BaseVolume& volume, const VolumeStatistics& statistics);

} // namespace stf
