// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/scene.h"

#include <string>

namespace fuzz {

/// What of two scenes differs, one line each, by the first scene's and the second's words; at most a dozen lines.
/// Meshes that are not drawn in either do not count: nobody has to keep them up to date. Prim ids are the host's
/// affair.
std::string sceneDifference(const stf::Scene& a, const stf::Scene& b);

} // namespace fuzz
