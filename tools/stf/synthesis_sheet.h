// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/quality.h"

#include <string>

namespace stf {

/// A sheet of pictures to judge a synthesis by: patches, coordinates (red along x, green along y of the tile), the
/// sample's reflectance on the object from two sides with its relief shaded, and two close-ups. Orthographic, by ray
/// casting; a quick look and no rendering of the material. Writes a PNG whole or not at all; throws Error.
void writeSynthesisSheet(const RefinedSurface& surface, const Synthesis& synthesis, const ExemplarMap& map,
                         const std::string& path);

} // namespace stf
