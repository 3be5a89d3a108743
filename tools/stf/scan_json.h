// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_acquire.h"

#include <string>

namespace stf {

/// One line of JSON: what was read, found and written (docs/acquire_scan.md).
std::string scanJson(const ScanRecipe& recipe, const AcquiredScan& scan, const std::string& path, double seconds);
/// A few lines to read.
std::string scanText(const AcquiredScan& scan, const std::string& path, double seconds);

} // namespace stf
