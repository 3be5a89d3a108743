// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/doctor/finding.h"

#include <optional>
#include <string>

namespace stf::doctor {

/// Where to look for the plugin.
struct PluginSearch {
    std::optional<std::string> path; ///< what PXR_PLUGINPATH_NAME says; none: it is not set
    std::string ownFolder;           ///< the plugin folder that belongs to this program
    std::string hostLibrary;         ///< a host's library of OpenUSD; empty: the one that the plugin finds
    std::string probe;               ///< the program stf-probe
};

/// Whether a host that reads this path sees the renderer, and can load it: entries of the path, plugInfo.json files,
/// plugins of the same name, the schemas, the library, the OpenUSD that it wants and gets, and the libraries that come
/// with it (TBB, Embree, OpenVDB ..).
Findings checkPlugin(const PluginSearch& search);

} // namespace stf::doctor
