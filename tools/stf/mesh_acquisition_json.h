// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/acquire/mesh_acquire.h"

#include <nlohmann/json.hpp>

namespace stf {

/// What was acquired, with what was found and repaired.
nlohmann::json describeAcquisition(const MeshAcquisition& acquisition, const std::string& path);

} // namespace stf
