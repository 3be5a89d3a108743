// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/image.h"

#include "pxr/imaging/hd/renderBuffer.h"

namespace stfrecord {

/// The content of a render buffer, rows turned to run from the top down. Whole numbers stay whole numbers; all other
/// formats become floats.
Layer readLayer(PXR_NS::HdRenderBuffer& buffer, const std::string& name);

} // namespace stfrecord
