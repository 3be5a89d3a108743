// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/window.h"
#include "tools/stfrecord/image.h"

#include "pxr/base/tf/token.h"
#include "pxr/base/vt/dictionary.h"
#include "pxr/imaging/hd/renderDelegate.h"
#include "pxr/usd/sdf/path.h"
#include "pxr/usd/usd/stage.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace stfrecord {

/// A Hydra host without GPU and window: render index, UsdImaging's delegate, one task with one render pass, one render
/// buffer per AOV. Works with any delegate that has render buffers. One thread.
class Host {
public:
    /// Throws std::runtime_error with a sentence where the delegate cannot be had.
    Host(const PXR_NS::UsdStageRefPtr& stage, const PXR_NS::TfToken& pluginId);
    ~Host();
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    PXR_NS::HdRenderDelegate& delegate();

    /// Brings the stage in, by UsdImaging's scene delegate or by its scene indices. Once, before the first frame.
    /// Throws std::runtime_error with a sentence where this OpenUSD has no scene indices for stages.
    void populate(const std::vector<std::string>& purposes, int refineLevel, bool sceneIndices);

    /// From now on what a camera's aperture holds fills the frame, whatever its shape: pixels of that width over
    /// height are not square.
    void fillFrame(float pixelAspectRatio);

    /// Size and AOVs of the images to come: `window` of a frame (rows from the bottom up). Returns the names of AOVs
    /// the delegate does not have; the others are bound.
    std::vector<std::string> setOutputs(const std::vector<std::string>& aovs, int frameWidth, int frameHeight,
                                        const PXR_NS::HdStfWindow& window);

    /// Renders until converged. Calls `poll` every few milliseconds; if that returns false rendering is stopped, and so
    /// is this with false.
    bool render(const PXR_NS::SdfPath& camera, PXR_NS::UsdTimeCode time, const std::function<bool()>& poll);

    /// The AOVs as they are now.
    Image readImage() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Plugin id of the renderer of that display name or id (letters' case aside); empty if there is none, with all names
/// in `available`.
PXR_NS::TfToken findRenderer(const std::string& name, std::vector<std::string>& available);

/// Makes the plugins known that lie in ../plugin of this executable: the delegate and the schemas.
void registerPlugins();

} // namespace stfrecord
