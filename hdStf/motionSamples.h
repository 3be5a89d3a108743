// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/base/gf/matrix4d.h"
#include "pxr/pxr.h"
#include "pxr/usd/sdf/path.h"

#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdSceneDelegate;

/// Times (frames from the present one) with matrices, in the order of time.
using HdStfMatrixSamples = std::vector<std::pair<double, GfMatrix4d>>;

/// What the scene delegate says of a prim's or an instancer's transform around the present time: at its host's shutter
/// and where a sample is authored in between. One sample, or equal ones, where nothing moves; none where the times are
/// no numbers.
HdStfMatrixSamples HdStfSampleTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id);
HdStfMatrixSamples HdStfSampleInstancerTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id);

PXR_NAMESPACE_CLOSE_SCOPE
