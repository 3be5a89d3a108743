// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace stf {

/// Throws Error where a NIfTI-1 file (.nii, .hdr with .img; packed or not) ends before its last voxel, which its
/// library fills up with zeros. Reads the header and the last byte that should be there.
void checkNiftiLength(const std::string& path);

} // namespace stf
