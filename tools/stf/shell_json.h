// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/shell/shell_grid.h"

#include <string>
#include <utility>
#include <vector>

namespace stf {

/// What `stf shell` reports.
struct ShellRun {
    std::size_t triangles = 0;
    double mmPerUnit = 1;
    float thickness = 0; ///< object units, as wanted
    std::string mapping;
    std::vector<std::pair<std::string, double>> seconds; ///< of the stages, in order
    double peakBytes = 0;                                ///< of the process
};

/// One line of JSON.
std::string shellJson(const ShellGrid& grid, const ShellBoundary& boundary, const ShellRun& run);
/// The same for people: a table of the levels, why the shell is thinner than wanted, and edges worth knowing.
std::string shellText(const ShellGrid& grid, const ShellBoundary& boundary, const ShellRun& run);

} // namespace stf
