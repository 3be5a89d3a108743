// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/product.h"

#include "pxr/usd/usd/stage.h"

#include <functional>
#include <string>
#include <vector>

namespace stfrecord {

/// What a RenderSettings prim asks for.
struct RenderSettings {
    std::vector<Product> products;
    std::vector<std::string> purposes; ///< includedPurposes
};

/// The prim at a path; for an empty one that of the stage's `renderSettingsPrimPath`. Empty where it is none; a path
/// that is named and is none gives a sentence in `problem`.
PXR_NS::SdfPath findRenderSettings(const PXR_NS::UsdStagePtr& stage, const std::string& path, std::string& problem);

/// Reads it: products with their cameras, windows, vars and settings of the renderer (attributes in its namespace
/// `stf:`). Says what of it is not done, a sentence each; products without a camera are left out.
RenderSettings readRenderSettings(const PXR_NS::UsdStagePtr& stage, const PXR_NS::SdfPath& path,
                                  PXR_NS::UsdTimeCode time, const std::function<void(const std::string&)>& complain);

/// Has a camera show what a product's frame covers, in the stage's session layer.
void setAperture(const PXR_NS::UsdStagePtr& stage, const Product& product);

} // namespace stfrecord
