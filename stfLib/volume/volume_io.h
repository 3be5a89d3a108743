// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <string>

namespace stf {

/// Reads a base volume (.vdb, contract version 1) and validates it. Voxels that `surface` places outside the material
/// become void. Throws Error with a message that starts with the path: missing or unreadable file, missing grid or
/// metadata, newer version, invalid values. Values that are legal but not used by this version (refraction, emission)
/// are reported to `messages`.
BaseVolume readBaseVolume(const std::string& path, const MessageSink& messages = {});

/// Writes a base volume; to a temporary file first, so that a reader never sees half of it. Throws Error.
void writeBaseVolume(const BaseVolume& volume, const std::string& path);

} // namespace stf
