// SPDX-License-Identifier: Apache-2.0

/// \file sceneIndexPlugins.cpp
/// Under scene indices a stage arrives as it was authored. Scene indices of Hydra's own, appended to the scenes of this
/// renderer, make of it what the delegate draws: what UsdImaging's scene delegate does by itself. None has a state of
/// the delegate's; Hydra appends them on any thread.

#include "hdStf/hydraCompat.h"

#if HDSTF_HAS_IMPLICIT_SURFACES

#include "pxr/base/tf/token.h"
#include "pxr/imaging/hd/dependencyForwardingSceneIndex.h"
#include "pxr/imaging/hd/retainedDataSource.h"
#include "pxr/imaging/hd/sceneIndexPlugin.h"
#include "pxr/imaging/hd/sceneIndexPluginRegistry.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/imaging/hdsi/implicitSurfaceSceneIndex.h"
#include "pxr/imaging/hdsi/nurbsApproximatingSceneIndex.h"
#if HDSTF_HAS_TET_MESHES
#include "pxr/imaging/hdsi/tetMeshConversionSceneIndex.h"
#endif
#if HDSTF_HAS_LINKS_AS_COLLECTIONS
#include "pxr/imaging/hdsi/lightLinkingSceneIndex.h"
#endif
#if HDSTF_HAS_COMPUTATION_DEPENDENCIES
#include "pxr/imaging/hdsi/extComputationDependencySceneIndex.h"
#endif

PXR_NAMESPACE_OPEN_SCOPE

namespace {

using _Registry = HdSceneIndexPluginRegistry;

/// First, what turns prims of one type to another.
constexpr _Registry::InsertionPhase _conversions = 0;
/// After procedurals, which make geometry and lights (phase 2).
constexpr _Registry::InsertionPhase _links = 4;
/// What says which prim depends on which; then, behind all others, what follows that.
constexpr _Registry::InsertionPhase _dependencies = 100, _forwarding = 1000;

void _Append(char const* plugin, _Registry::InsertionPhase phase, HdContainerDataSourceHandle const& args = nullptr,
             _Registry::InsertionOrder order = _Registry::InsertionOrderAtStart) {
    _Registry::GetInstance().RegisterSceneIndexForRenderer("Stf", TfToken(plugin), args, phase, order);
}

} // namespace

/// A plugin that appends one scene index: plugins are found by the names of their classes, in plugInfo.json.
#define HDSTF_SCENE_INDEX_PLUGIN(PLUGIN, SCENE_INDEX)                                                                  \
    class PLUGIN final : public HdSceneIndexPlugin {                                                                   \
    protected:                                                                                                         \
        HdSceneIndexBaseRefPtr _AppendSceneIndex(HdSceneIndexBaseRefPtr const& scene,                                  \
                                                 [[maybe_unused]] HdContainerDataSourceHandle const& args) override {  \
            return SCENE_INDEX;                                                                                        \
        }                                                                                                              \
    };                                                                                                                 \
    TF_REGISTRY_FUNCTION_WITH_TAG(TfType, PLUGIN) {                                                                    \
        _Registry::Define<PLUGIN>();                                                                                   \
    }

/// Spheres, cubes and the like become meshes.
HDSTF_SCENE_INDEX_PLUGIN(HdStf_ImplicitSurfaceSceneIndexPlugin, HdsiImplicitSurfaceSceneIndex::New(scene, args))
/// Patches and curves with weights and knots become meshes and curves without, by their control points.
HDSTF_SCENE_INDEX_PLUGIN(HdStf_NurbsSceneIndexPlugin, HdsiNurbsApproximatingSceneIndex::New(scene))
#if HDSTF_HAS_TET_MESHES
/// Of meshes of tetrahedra, the surface.
HDSTF_SCENE_INDEX_PLUGIN(HdStf_TetMeshSceneIndexPlugin, HdsiTetMeshConversionSceneIndex::New(scene))
#endif
#if HDSTF_HAS_LINKS_AS_COLLECTIONS
/// Light and shadow links, which are collections, become categories, of which the delegate is told.
HDSTF_SCENE_INDEX_PLUGIN(HdStf_LightLinkingSceneIndexPlugin, HdsiLightLinkingSceneIndex::New(scene, args))
#endif
#if HDSTF_HAS_COMPUTATION_DEPENDENCIES
/// Points that are computed (skinning) change with what they are computed from.
HDSTF_SCENE_INDEX_PLUGIN(HdStf_ComputationSceneIndexPlugin, HdsiExtComputationDependencySceneIndex::New(scene))
#endif
/// What depends on something that changes changes: meshes of implicit surfaces, say, with the radius.
HDSTF_SCENE_INDEX_PLUGIN(HdStf_DependencySceneIndexPlugin, HdDependencyForwardingSceneIndex::New(scene))

TF_REGISTRY_FUNCTION(HdSceneIndexPlugin) {
    const HdDataSourceBaseHandle toMesh =
        HdRetainedTypedSampledDataSource<TfToken>::New(HdsiImplicitSurfaceSceneIndexTokens->toMesh);
    _Append("HdStf_ImplicitSurfaceSceneIndexPlugin", _conversions,
            HdRetainedContainerDataSource::New(HdPrimTypeTokens->sphere, toMesh, HdPrimTypeTokens->cube, toMesh,
                                               HdPrimTypeTokens->cone, toMesh, HdPrimTypeTokens->cylinder, toMesh,
                                               HdPrimTypeTokens->capsule, toMesh));
    _Append("HdStf_NurbsSceneIndexPlugin", _conversions);
#if HDSTF_HAS_TET_MESHES
    _Append("HdStf_TetMeshSceneIndexPlugin", _conversions);
#endif
#if HDSTF_HAS_LINKS_AS_COLLECTIONS
    _Append("HdStf_LightLinkingSceneIndexPlugin", _links);
#endif
#if HDSTF_HAS_COMPUTATION_DEPENDENCIES
    _Append("HdStf_ComputationSceneIndexPlugin", _dependencies);
#endif
    _Append("HdStf_DependencySceneIndexPlugin", _forwarding, nullptr, _Registry::InsertionOrderAtEnd);
}

PXR_NAMESPACE_CLOSE_SCOPE

#endif // HDSTF_HAS_IMPLICIT_SURFACES
