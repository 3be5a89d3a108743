// SPDX-License-Identifier: Apache-2.0
#pragma once

// Private to the shell layer.

#include "stfLib/shell/shell_grid_impl.h"
#include "stfLib/shell/shell_probes.h"

namespace stf {

/// Fills the errors of a level's report by looking up all probes at it.
void measureLevel(const ShellGridData& grid, int level, const std::vector<ProbedPoint>& probes, double texelMm,
                  ShellLevelReport& report);

} // namespace stf
