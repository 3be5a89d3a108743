// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/scene.h"

#include <map>
#include <string>

namespace fuzz {

/// Names that a first scene has for meshes of a second one. UsdImaging names what native instances share after
/// whichever of them it met first: added later, or after another was removed, that is another one than in a host that
/// sees all at once.
using HostNames = std::map<std::string, std::string>;

/// Those that are drawn by different names with the same instances.
HostNames hostNames(const stf::Scene& a, const stf::Scene& b);
/// The id itself where it has no other name.
std::string nameInFirst(const HostNames& names, const std::string& id);

/// What of two scenes differs, one line each, by the first scene's and the second's words; at most a dozen lines.
/// Meshes that are not drawn in either do not count: nobody has to keep them up to date. Prim ids are the host's
/// affair.
std::string sceneDifference(const stf::Scene& a, const stf::Scene& b);

} // namespace fuzz
