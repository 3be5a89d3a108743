// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/prepared_scene.h"

namespace stf {

/// Sets the world bounds of instances, and which of them overlap others.
void findOverlaps(std::vector<PreparedInstance>& instances);

/// Numbers of the instances of shells whose bounds overlap a box (world).
std::vector<std::uint32_t> shellsAround(const std::vector<PreparedInstance>& instances, const Box3f& box);

} // namespace stf
