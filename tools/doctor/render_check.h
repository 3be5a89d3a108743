// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/doctor/finding.h"

#include <string>

namespace stf::doctor {

/// Renders a shell of 8 x 8 pixels by the program `stfrecord`, in a temporary folder with a cache of its own; takes a
/// second or two.
Findings checkRender(const std::string& stfrecord);

} // namespace stf::doctor
