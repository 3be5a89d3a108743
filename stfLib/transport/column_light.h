// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/direction_walks.h"

namespace stf {

/// Fills what leaves through the bottom of each column, and the top, per direction (DESIGN 3.10). `walked` is empty
/// where nothing scatters: all that arrives is what did not collide.
void lightColumns(TileWalks& c, const std::vector<DirectionLight>& walked, StfTable& t);

} // namespace stf
