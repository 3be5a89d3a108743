// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_recipe.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace stf {

/// The command line of `stf acquire scan`: it becomes a patch of the recipe, so that both are read by one reader.
class ScanArguments {
public:
    void addTo(CLI::App& command);
    /// Throws Error for what the recipe's reader does not take, CLI::ValidationError for words that make no recipe.
    ScanRecipe recipe() const;
    const std::string& out() const { return files_.back(); }
    int threads() const { return threads_; }
    bool json() const { return json_; }

private:
    std::vector<std::string> files_, points_;
    std::string recipe_, series_, crop_, depth_, method_, gradient_, tile_, iso_, top_, name_, type_, endian_, table_,
        core_;
    std::vector<std::string> materials_;
    std::vector<double> dims_, spacing_, voxel_, thresholds_, widths_, overlap_;
    std::vector<double> scale_, nan_, smooth_, memory_, headerBytes_; ///< empty or one number
    int threads_ = 0;
    bool json_ = false;
};

} // namespace stf
