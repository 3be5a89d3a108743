// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <string>

namespace stf {

/// Writes a volume for programs that read no OpenVDB: FOLDER/volume.json names size (x, y, z), voxelMm and the grids,
/// each with its file of 32-bit floats in the machine's byte order, [z][y][x][channel]. Throws Error.
void writeRaw(const BaseVolume& volume, const std::string& folder);

} // namespace stf
