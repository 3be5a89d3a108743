// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"
#include "stfLib/volume/volume_statistics.h"

#include <string>

namespace stf {

/// A PNG that shows a volume: four tiles side by side seen from above, cuts at four depths, slices along x and y,
/// extinction, the surface's height and normals, histograms; with axes in mm and a scale bar. Colours of cuts are the
/// diffuse reflectance that a deep medium of the voxel's coefficients would have; voids are dark blue-grey. Throws
/// std::runtime_error.
void writeVolumeSheet(const BaseVolume& volume, const VolumeStatistics& statistics, const std::string& path);

} // namespace stf
