// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/usd/sdf/path.h"
#include "pxr/usd/usd/stage.h"

#include <string>
#include <vector>

namespace stfrecord {

/// All cameras of a stage in traversal order.
PXR_NS::SdfPathVector findCameras(const PXR_NS::UsdStagePtr& stage);

/// The camera at that path or of that name; the first one if `name` is empty. Empty if there is none.
PXR_NS::SdfPath findCamera(const PXR_NS::UsdStagePtr& stage, const std::string& name);

/// Defines a camera in the stage's session layer that sees all that is drawn for the purposes (from the front: along
/// -z where y is up, along y where z is up), and returns its path.
PXR_NS::SdfPath defineFramingCamera(const PXR_NS::UsdStagePtr& stage, PXR_NS::UsdTimeCode time,
                                    const std::vector<std::string>& purposes);

/// Height of an image of that width, from the camera's aperture. At least 1.
int imageHeight(const PXR_NS::UsdStagePtr& stage, const PXR_NS::SdfPath& camera, PXR_NS::UsdTimeCode time, int width);

} // namespace stfrecord
