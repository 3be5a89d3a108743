// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/usd/sdf/path.h"
#include "pxr/usd/usd/stage.h"

#include <memory>
#include <string>
#include <vector>

namespace stfrecord {

/// A stage brought into a render index by UsdImaging, in one of two ways: by its scene delegate, which every version of
/// OpenUSD has, or by its scene indices, which hosts use by default from 25.11 on. A delegate should see no difference.
/// One thread; destroyed before the index.
class StageScene {
public:
    enum class Way { Delegate, SceneIndices };

    /// `purposes` are those of UsdGeom (default, render, proxy, guide) that the scene delegate brings; scene indices
    /// bring all, and render tags choose. Throws std::runtime_error with a sentence where this OpenUSD has no such way.
    StageScene(PXR_NS::HdRenderIndex& index, const PXR_NS::UsdStageRefPtr& stage, Way way,
               const std::vector<std::string>& purposes = {"default"}, int refineLevel = 0);
    ~StageScene();
    StageScene(const StageScene&) = delete;
    StageScene& operator=(const StageScene&) = delete;

    /// The camera whose shutter says when transforms are sampled. Scene indices know no such camera.
    void setCameraForSampling(const PXR_NS::SdfPath& camera);
    /// A camera's aperture is stretched to the frame; by itself it is fitted in. Scene indices leave that to framing.
    void fillFrame();
    void setTime(PXR_NS::UsdTimeCode time);
    /// Of all prims, and of one. Scene indices have no level of a single prim.
    void setRefineLevelFallback(int level);
    void setRefineLevel(const PXR_NS::SdfPath& prim, int level);
    /// Hands edits of the stage over.
    void applyPendingUpdates();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace stfrecord
