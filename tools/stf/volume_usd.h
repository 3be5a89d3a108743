// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <string>

namespace stf {

/// Writes a USD scene (.usda) that shows the grids of a base volume as a UsdVol Volume with an OpenVDBAsset for each,
/// for hosts that draw volumes: in millimetres, the tile's top at z = 0 and up. `volumePath` is the .vdb; the scene
/// names it relative to itself where they share a folder. Throws std::runtime_error.
void writeVolumeUsd(const BaseVolume& volume, const std::string& volumePath, const std::string& path);

} // namespace stf
