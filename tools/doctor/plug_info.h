// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace stf::doctor {

/// A plugin as a plugInfo.json describes it.
struct DescribedPlugin {
    std::string name;
    std::string file;    ///< the plugInfo.json
    std::string library; ///< where its library must be; empty: it has none
    std::string openUsd; ///< of hdStf: the version of OpenUSD that it was built for; empty where it does not say
};

/// What OpenUSD would read from one entry of its plugin path.
struct PlugInfoReading {
    std::vector<std::string> files; ///< that were read, in order
    std::vector<DescribedPlugin> plugins;
    std::vector<std::string> faults; ///< sentences without full stops, each beginning with the file
};

/// Reads an entry of PXR_PLUGINPATH_NAME as OpenUSD does: a folder's plugInfo.json or the file itself, lines that begin
/// with # left out, "Includes" followed (with * and ? in them; ** counts as *). At most a thousand files of at most
/// 16 MB each.
PlugInfoReading readPlugInfo(const std::string& entry);

} // namespace stf::doctor
