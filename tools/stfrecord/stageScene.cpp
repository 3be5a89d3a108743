// SPDX-License-Identifier: Apache-2.0
#include "tools/stfrecord/stageScene.h"

#include "hdStf/hydraCompat.h"

#include "pxr/usdImaging/usdImaging/delegate.h"
#if HDSTF_HAS_STAGE_SCENE_INDICES
#include "pxr/imaging/hdsi/legacyDisplayStyleOverrideSceneIndex.h"
#include "pxr/usdImaging/usdImaging/sceneIndices.h"
#include "pxr/usdImaging/usdImaging/selectionSceneIndex.h"
#include "pxr/usdImaging/usdImaging/stageSceneIndex.h"
#endif

#include <algorithm>
#include <stdexcept>

namespace stfrecord {

PXR_NAMESPACE_USING_DIRECTIVE

struct StageScene::Impl {
    std::unique_ptr<UsdImagingDelegate> delegate;
#if HDSTF_HAS_STAGE_SCENE_INDICES
    HdRenderIndex* index = nullptr;
    UsdImagingSceneIndices indices;
    HdsiLegacyDisplayStyleOverrideSceneIndexRefPtr style; // what was inserted
#endif
};

StageScene::StageScene(HdRenderIndex& index, const UsdStageRefPtr& stage, Way way,
                       const std::vector<std::string>& purposes, int refineLevel)
    : impl_(new Impl) {
    if (way == Way::Delegate) {
        impl_->delegate = std::make_unique<UsdImagingDelegate>(&index, SdfPath::AbsoluteRootPath());
        const auto has = [&purposes](const char* name) {
            return std::find(purposes.begin(), purposes.end(), name) != purposes.end();
        };
        impl_->delegate->SetDisplayRender(has("render"));
        impl_->delegate->SetDisplayProxy(has("proxy"));
        impl_->delegate->SetDisplayGuides(has("guide"));
        impl_->delegate->SetRefineLevelFallback(refineLevel);
        impl_->delegate->Populate(stage->GetPseudoRoot());
        return;
    }
#if HDSTF_HAS_STAGE_SCENE_INDICES
#if HDSTF_HAS_SCENE_INDEX_SWITCH
    if (!HdRenderIndex::IsSceneIndexEmulationEnabled()) {
        throw std::runtime_error("scene indices are switched off (HD_ENABLE_SCENE_INDEX_EMULATION)");
    }
#endif
    UsdImagingCreateSceneIndicesInfo info;
    info.stage = stage;
    impl_->index = &index;
    impl_->indices = UsdImagingCreateSceneIndices(info);
    impl_->style = HdsiLegacyDisplayStyleOverrideSceneIndex::New(impl_->indices.finalSceneIndex);
    setRefineLevelFallback(refineLevel);
    index.InsertSceneIndex(impl_->style, SdfPath::AbsoluteRootPath());
#else
    throw std::runtime_error("this OpenUSD brings stages in by its scene delegate only: scene indices came with 23.11");
#endif
}

StageScene::~StageScene() {
#if HDSTF_HAS_STAGE_SCENE_INDICES
    if (impl_->style) {
        impl_->index->RemoveSceneIndex(impl_->style);
    }
#endif
}

void StageScene::setCameraForSampling(const SdfPath& camera) {
    if (impl_->delegate) {
        impl_->delegate->SetCameraForSampling(camera);
    }
}

void StageScene::fillFrame() {
    if (impl_->delegate) {
        impl_->delegate->SetWindowPolicy(CameraUtilDontConform);
    }
}

void StageScene::setRefineLevelFallback(int level) {
    if (impl_->delegate) {
        impl_->delegate->SetRefineLevelFallback(level);
    }
#if HDSTF_HAS_STAGE_SCENE_INDICES
    if (impl_->style) {
#if HDSTF_HAS_REFINE_LEVEL_FALLBACK
        impl_->style->SetRefineLevelFallback(level);
#else
        impl_->style->SetRefineLevel({true, level});
#endif
    }
#endif
}

void StageScene::setRefineLevel(const SdfPath& prim, int level) {
    if (impl_->delegate) {
        impl_->delegate->SetRefineLevel(prim, level);
    }
}

void StageScene::setTime(UsdTimeCode time) {
    if (impl_->delegate) {
        impl_->delegate->SetTime(time);
    }
#if HDSTF_HAS_STAGE_SCENE_INDICES
    if (impl_->style) {
        impl_->indices.stageSceneIndex->SetTime(time);
    }
#endif
}

void StageScene::applyPendingUpdates() {
    if (impl_->delegate) {
        impl_->delegate->ApplyPendingUpdates();
    }
#if HDSTF_HAS_STAGE_SCENE_INDICES
    if (impl_->style) {
        impl_->indices.stageSceneIndex->ApplyPendingUpdates();
    }
#endif
}

} // namespace stfrecord
