// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"

#include "pxr/pxr.h"
#include "pxr/usd/sdf/path.h"

PXR_NAMESPACE_OPEN_SCOPE

class HdSceneDelegate;

/// Where in the scene an instance of an rprim is from: the path that an artist knows. The rprim's own id where the host
/// does not tell. Hydra's sync threads.
SdfPath HdStfScenePath(HdSceneDelegate* sceneDelegate, SdfPath const& id, int instance);

PXR_NAMESPACE_CLOSE_SCOPE
