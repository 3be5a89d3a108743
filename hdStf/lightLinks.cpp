// SPDX-License-Identifier: Apache-2.0

/// \file lightLinks.cpp
/// Under scene indices, light and shadow links arrive as collections: they are resolved to categories, which is what
/// this delegate is told of, before it sees lights and geometry.

#include "hdStf/hydraCompat.h"

#if HDSTF_HAS_LINKS_AS_COLLECTIONS

#include "pxr/base/tf/staticTokens.h"
#include "pxr/imaging/hd/sceneIndexPlugin.h"
#include "pxr/imaging/hd/sceneIndexPluginRegistry.h"
#include "pxr/imaging/hdsi/lightLinkingSceneIndex.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_DEFINE_PRIVATE_TOKENS(_tokens, ((pluginName, "HdStf_LightLinkingSceneIndexPlugin")));

/// \class HdStf_LightLinkingSceneIndexPlugin
///
/// Appends Hydra's own scene index for links to the scenes of this renderer. No state, any thread.
class HdStf_LightLinkingSceneIndexPlugin final : public HdSceneIndexPlugin {
protected:
    HdSceneIndexBaseRefPtr _AppendSceneIndex(HdSceneIndexBaseRefPtr const& inputScene,
                                             HdContainerDataSourceHandle const& inputArgs) override {
        return HdsiLightLinkingSceneIndex::New(inputScene, inputArgs);
    }
};

TF_REGISTRY_FUNCTION(TfType) {
    HdSceneIndexPluginRegistry::Define<HdStf_LightLinkingSceneIndexPlugin>();
}

TF_REGISTRY_FUNCTION(HdSceneIndexPlugin) {
    // After procedurals, which make geometry and lights (phase 2), and after implicit surfaces have become meshes.
    HdSceneIndexPluginRegistry::GetInstance().RegisterSceneIndexForRenderer(
        "Stf", _tokens->pluginName, /*inputArgs*/ nullptr, /*insertionPhase*/ 4,
        HdSceneIndexPluginRegistry::InsertionOrderAtStart);
}

PXR_NAMESPACE_CLOSE_SCOPE

#endif // HDSTF_HAS_LINKS_AS_COLLECTIONS
