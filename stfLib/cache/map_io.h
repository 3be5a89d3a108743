// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/synthesis/exemplar_map.h"

#include <string>

namespace stf {

/// Writes exemplar coordinates as they are in memory, behind a line that names the format and their number. Bytes are
/// in the machine's order: the file is of this machine's cache. Throws Error with a message that starts with the path.
void writeExemplarMap(const ExemplarMap& map, const std::string& path);
/// Throws Error with a message that starts with the path where it is not a whole file of that kind.
ExemplarMap readExemplarMap(const std::string& path);

} // namespace stf
