// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace stfrecord {

/// Calls `write` with a temporary name beside `path` (same extension) and renames it to `path`, so that a reader never
/// sees half a file. On an exception the temporary file is removed. Throws std::runtime_error if renaming fails.
void writeAtomically(const std::string& path, const std::function<void(const std::string&)>& write);

} // namespace stfrecord
