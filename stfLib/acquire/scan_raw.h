// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/scan_reader.h"

namespace stf {

/// A block of voxels behind a header of known length, read layer by layer; files whose name ends in .gz are unpacked as
/// they are read. `header.size` and `.type` are those of the layout. Throws Error where the file ends early.
std::unique_ptr<ScanReader> openVoxelBlock(const std::string& path, const RawLayout& layout, const ScanHeader& header);

/// A file by the layout that the user gives; reports bytes that are left over.
std::unique_ptr<ScanReader> openRaw(const std::string& path, const RawLayout& layout, const MessageSink& messages);

} // namespace stf
