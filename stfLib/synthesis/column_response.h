// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <vector>

namespace stf {

/// Diffuse reflectance of each column of a volume (x fastest), per channel, 0 to 1, as if light stayed in its column:
/// Kubelka & Munk's two streams ("Ein Beitrag zur Optik der Farbanstriche", 1931) through the layers, over a core of
/// infinite depth, with K = 2 sigma_a and S = 3/4 sigma_s' - 1/4 sigma_a (not below 0; Mudgett & Richards 1971). Tells
/// columns apart as an eye does, without walks; it is no answer of the renderer.
std::vector<Rgb> columnResponse(const BaseVolume& volume);

/// Reflectance of a layer of thickness d (mm) with K and S (1/mm) over a background of reflectance `below`.
double layerReflectance(double k, double s, double d, double below);

} // namespace stf
