// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/options.h"

#include "pxr/base/vt/dictionary.h"
#include "pxr/imaging/hd/renderDelegate.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace stfrecord {

/// Hands the options' settings to a delegate, in the types of its defaults. Returns a sentence where one does not
/// exist or cannot be read, else nothing.
std::string applySettings(PXR_NS::HdRenderDelegate& delegate, const Options& options, double metersPerUnit);

/// Sets the part of the frame to render; empty: all of it. Returns a sentence where the delegate cannot.
std::string setDataWindow(PXR_NS::HdRenderDelegate& delegate, const std::optional<std::array<float, 4>>& window);

/// Settings of render products: each product's stand for its time, what they replaced comes back for the next.
class ProductSettings {
public:
    explicit ProductSettings(PXR_NS::HdRenderDelegate& delegate) : delegate_(delegate) {}
    /// Returns a sentence for each key that the delegate does not have.
    std::vector<std::string> apply(const PXR_NS::VtDictionary& settings);

private:
    PXR_NS::HdRenderDelegate& delegate_;
    PXR_NS::VtDictionary replaced_;
};

/// All settings as they stand, for the image's metadata: `key=value` joined by spaces.
std::string describeSettings(const PXR_NS::HdRenderDelegate& delegate);

} // namespace stfrecord
