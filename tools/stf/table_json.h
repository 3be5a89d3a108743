// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/transport/stf_table.h"

#include <nlohmann/json.hpp>

namespace stf {

/// What a table is and how it was made; reads none of its large parts.
nlohmann::json describeTable(const StfTable& table);

} // namespace stf
