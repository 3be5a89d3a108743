// SPDX-License-Identifier: Apache-2.0
#include "tools/stf/commands.h"

namespace stf {

void addAcquireCommand(CLI::App& app) {
    auto* group = app.add_subcommand("acquire", "Make a base volume from measured or modelled data");
    group->require_subcommand(1);
    addAcquireMeshCommand(*group);
    addAcquireScanCommand(*group);
}

} // namespace stf
