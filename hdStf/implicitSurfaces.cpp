// SPDX-License-Identifier: Apache-2.0

/// \file implicitSurfaces.cpp
/// Under scene indices, implicit surfaces become meshes before this delegate sees them.

#include "hdStf/hydraCompat.h"

#if HDSTF_HAS_IMPLICIT_SURFACES

#include "pxr/base/tf/staticTokens.h"
#include "pxr/imaging/hd/retainedDataSource.h"
#include "pxr/imaging/hd/sceneIndexPlugin.h"
#include "pxr/imaging/hd/sceneIndexPluginRegistry.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/imaging/hdsi/implicitSurfaceSceneIndex.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_DEFINE_PRIVATE_TOKENS(_tokens, ((pluginName, "HdStf_ImplicitSurfaceSceneIndexPlugin")));

/// \class HdStf_ImplicitSurfaceSceneIndexPlugin
///
/// Appends Hydra's own scene index for implicit surfaces to the scenes of this renderer. No state, any thread.
class HdStf_ImplicitSurfaceSceneIndexPlugin final : public HdSceneIndexPlugin {
protected:
    HdSceneIndexBaseRefPtr _AppendSceneIndex(HdSceneIndexBaseRefPtr const& inputScene,
                                             HdContainerDataSourceHandle const& inputArgs) override {
        return HdsiImplicitSurfaceSceneIndex::New(inputScene, inputArgs);
    }
};

TF_REGISTRY_FUNCTION(TfType) {
    HdSceneIndexPluginRegistry::Define<HdStf_ImplicitSurfaceSceneIndexPlugin>();
}

TF_REGISTRY_FUNCTION(HdSceneIndexPlugin) {
    const HdDataSourceBaseHandle toMesh =
        HdRetainedTypedSampledDataSource<TfToken>::New(HdsiImplicitSurfaceSceneIndexTokens->toMesh);
    const HdContainerDataSourceHandle args = HdRetainedContainerDataSource::New(
        HdPrimTypeTokens->sphere, toMesh, HdPrimTypeTokens->cube, toMesh, HdPrimTypeTokens->cone, toMesh,
        HdPrimTypeTokens->cylinder, toMesh, HdPrimTypeTokens->capsule, toMesh);
    HdSceneIndexPluginRegistry::GetInstance().RegisterSceneIndexForRenderer(
        "Stf", _tokens->pluginName, args, /*insertionPhase*/ 0, HdSceneIndexPluginRegistry::InsertionOrderAtStart);
}

PXR_NAMESPACE_CLOSE_SCOPE

#endif // HDSTF_HAS_IMPLICIT_SURFACES
