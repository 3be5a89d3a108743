// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/doctor/finding.h"

namespace stf::doctor {

/// Open Image Denoise: there or not. A problem of nobody who does not want it.
Findings checkDenoiser();

/// The cache's folder: whether it can be written, what it holds, its limit, and the space left on its disk.
Findings checkCache();

/// Free memory and the processors that this process may use.
Findings checkMachine();

} // namespace stf::doctor
