// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/stfrecord/image.h"

#include "pxr/base/gf/vec2f.h"
#include "pxr/base/vt/dictionary.h"
#include "pxr/usd/sdf/path.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace stfrecord {

/// An AOV of the renderer as an image holds it.
struct ProductVar {
    std::string aov;      ///< of the renderer
    std::string layer;    ///< of the image
    std::string dataType; ///< USD's name of a type; empty: as the renderer has it
};

/// One image of the scene: of the command line, or a RenderProduct.
struct Product {
    std::string name; ///< of its prim; empty: the command line's
    std::string file; ///< productName; empty: the command line's
    PXR_NS::SdfPath camera;
    int width = 0, height = 0; ///< of the frame, pixels; height 0: follows from the camera
    float pixelAspectRatio = 1;
    /// What of the camera's film the frame covers, in its units; empty: what the camera says.
    std::optional<PXR_NS::GfVec2f> aperture;
    /// Of the frame: x and y from, x and y to, shares from its lower left.
    std::optional<std::array<float, 4>> dataWindow;
    std::vector<ProductVar> vars;
    PXR_NS::VtDictionary settings; ///< of the renderer, by key
};

/// The AOVs that a name stands for: `cryptoObject` for its layers, any other for itself.
std::vector<std::string> aovsOf(const std::string& name);

/// The layers of a product, in its order, from those that were rendered: named, and in the precision and with the
/// channels, that its vars ask for. What cannot be is said in `problems`, a sentence each.
std::vector<Layer> productLayers(const std::vector<ProductVar>& vars, std::vector<Layer> rendered,
                                 std::vector<std::string>& problems);

} // namespace stfrecord
