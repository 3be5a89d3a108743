// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/base/tf/token.h"
#include "pxr/usd/usd/stage.h"

#include <string>
#include <vector>

namespace stfrecord {

/// Curves, points and volumes that a renderer does not draw: UsdImaging hands it only the types of prims that it names,
/// and says nothing of the others. A sentence per type, with their number, the first of them, and the bounds of volumes
/// at `time`. Invisible prims, and those of purposes that are not asked for, do not count.
std::vector<std::string> describeLeftOut(const PXR_NS::UsdStagePtr& stage, const PXR_NS::TfTokenVector& drawnTypes,
                                         const std::vector<std::string>& purposes, PXR_NS::UsdTimeCode time);

} // namespace stfrecord
