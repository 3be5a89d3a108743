// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/motion.h"

#include "pxr/base/gf/matrix4d.h"
#include "pxr/pxr.h"
#include "pxr/usd/sdf/path.h"

#include <utility>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdSceneDelegate;

/// Times (frames from the present one) with matrices, in the order of time.
using HdStfMatrixSamples = std::vector<std::pair<double, GfMatrix4d>>;

/// What the scene delegate says of a prim's or an instancer's transform around the present time: at the
/// shutter's opening and closing and where a sample is authored in between. OpenUSD before 24.08 takes the shutter of
/// the camera that the host named to it, whatever \p shutter says. One sample, or equal ones, where nothing moves; none
/// where the times are no numbers.
HdStfMatrixSamples HdStfSampleTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id, stf::Shutter const& shutter);
HdStfMatrixSamples HdStfSampleInstancerTransform(HdSceneDelegate* sceneDelegate, SdfPath const& id,
                                                 stf::Shutter const& shutter);

PXR_NAMESPACE_CLOSE_SCOPE
