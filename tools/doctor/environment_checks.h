// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/doctor/finding.h"

#include <string>
#include <utility>
#include <vector>

namespace stf::doctor {

using Variables = std::vector<std::pair<std::string, std::string>>; ///< names and values

/// The environment of this process.
Variables environmentVariables();

/// Which of hdStf's variables are set, to what; values that no setting takes, names that are near to ones that are
/// known, and names that are near to PXR_PLUGINPATH_NAME.
Findings checkEnvironment(const Variables& variables);

} // namespace stf::doctor
