// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/options.h"

#include "pxr/imaging/hd/renderDelegate.h"

#include <string>

namespace stfrecord {

/// Hands the options' settings to a delegate, in the types of its defaults. Returns a sentence where one does not
/// exist or cannot be read, else nothing.
std::string applySettings(PXR_NS::HdRenderDelegate& delegate, const Options& options, double metersPerUnit);

/// All settings as they stand, for the image's metadata: `key=value` joined by spaces.
std::string describeSettings(const PXR_NS::HdRenderDelegate& delegate);

} // namespace stfrecord
