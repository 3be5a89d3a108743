// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stf {

/// The text of stfLib/optics/materials.json, part of the program since the build.
const char* builtInMaterialsJson();

} // namespace stf
