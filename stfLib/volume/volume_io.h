// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/volume/base_volume.h"

#include <string>

namespace stf {

/// Reads a base volume (.vdb, contract version 1) and validates it. Throws Error with a message that starts with the
/// path: missing or unreadable file, missing grid or metadata, newer version, invalid values. What is legal but not
/// what its maker may expect is reported to `messages`.
BaseVolume readBaseVolume(const std::string& path, const MessageSink& messages = {});

/// Writes a base volume; to a temporary file first, so that a reader never sees half of it. Throws Error.
void writeBaseVolume(const BaseVolume& volume, const std::string& path);

} // namespace stf
