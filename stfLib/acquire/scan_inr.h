// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_reader.h"

namespace stf {

/// INRIMAGE-4 (INRIA; read by CGAL and medInria): text of "KEY=value" lines in blocks of 256 bytes that ends with
/// "##}", then the voxels. Throws Error that names what of the header is missing or wrong.
std::unique_ptr<ScanReader> openInr(const std::string& path);

} // namespace stf
