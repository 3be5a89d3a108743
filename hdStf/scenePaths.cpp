// SPDX-License-Identifier: Apache-2.0
#include "hdStf/scenePaths.h"

#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/sceneDelegate.h"

#if HDSTF_HAS_PRIM_ORIGINS
#include "pxr/imaging/hd/instancedBySchema.h"
#include "pxr/imaging/hd/instancerTopologySchema.h"
#include "pxr/imaging/hd/primOriginSchema.h"
#include "pxr/imaging/hd/sceneIndex.h"
#include "pxr/imaging/hd/tokens.h"
#endif

#include <algorithm>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

#if HDSTF_HAS_PRIM_ORIGINS

namespace {

/// The way on from \p path: an absolute one replaces it, a relative one (inside a prototype) goes on from it.
void _Append(HdContainerDataSourceHandle const& source, SdfPath* path) {
    HdPrimOriginSchema schema = HdPrimOriginSchema::GetFromParent(source);
    const SdfPath origin = schema ? schema.GetOriginPath(HdPrimOriginSchemaTokens->scenePath) : SdfPath();
    if (!origin.IsEmpty()) {
        *path = origin.IsAbsolutePath() || path->IsEmpty() ? origin : path->AppendPath(origin);
    }
}

SdfPath _First(HdPathArrayDataSourceHandle const& paths) {
    const VtArray<SdfPath> values = paths ? paths->GetTypedValue(0) : VtArray<SdfPath>();
    return values.empty() ? SdfPath() : values[0];
}

/// As HdxPrimOriginInfo of OpenUSD puts a path together: that of the outermost native instance, and from prototype to
/// prototype what it is inside of it. An instance's number counts the innermost instancer's fastest.
SdfPath _OriginOf(HdSceneIndexBase& scene, SdfPath const& id, int instance) {
    std::vector<HdContainerDataSourceHandle> way; // from the inside
    SdfPath path = id;
    HdContainerDataSourceHandle source = scene.GetPrim(path).dataSource;
    way.push_back(source);
    while (source) {
        const SdfPath instancer = _First(HdInstancedBySchema::GetFromParent(source).GetPaths());
        source = instancer.IsEmpty() ? nullptr : scene.GetPrim(instancer).dataSource;
        HdInstancerTopologySchema topology = HdInstancerTopologySchema::GetFromParent(source);
        const VtArray<int> indices = topology ? topology.ComputeInstanceIndicesForProto(path) : VtArray<int>();
        if (indices.empty()) {
            break;
        }
        const int index = indices[static_cast<size_t>(instance) % indices.size()];
        instance = static_cast<int>(static_cast<size_t>(instance) / indices.size());
        HdPathArrayDataSourceHandle const locations = topology.GetInstanceLocations();
        const VtArray<SdfPath> places = locations ? locations->GetTypedValue(0) : VtArray<SdfPath>();
        if (index >= 0 && static_cast<size_t>(index) < places.size()) {
            way.push_back(scene.GetPrim(places[static_cast<size_t>(index)]).dataSource);
        }
        path = instancer;
    }
    SdfPath origin;
    for (auto it = way.rbegin(); it != way.rend(); ++it) {
        if (*it) {
            _Append(*it, &origin);
        }
    }
    return origin;
}

} // namespace

SdfPath HdStfScenePath(HdSceneDelegate* sceneDelegate, SdfPath const& id, int instance) {
    HdSceneIndexBaseRefPtr const scene = sceneDelegate->GetRenderIndex().GetTerminalSceneIndex();
    HdContainerDataSourceHandle const source = scene ? scene->GetPrim(id).dataSource : nullptr;
    if (!source) {
        return sceneDelegate->GetScenePrimPath(id, instance);
    }
    // What answers here stands in front of the host's own delegate and does not pass the question on.
    if (auto const legacy =
            HdTypedSampledDataSource<HdSceneDelegate*>::Cast(source->Get(HdSceneIndexEmulationTokens->sceneDelegate))) {
        if (HdSceneDelegate* const own = legacy->GetTypedValue(0)) {
            return own->GetScenePrimPath(id, instance);
        }
    }
    const SdfPath origin = _OriginOf(*scene, id, instance);
    return origin.IsEmpty() ? id : origin;
}

#else

SdfPath HdStfScenePath(HdSceneDelegate* sceneDelegate, SdfPath const& id, int instance) {
    return sceneDelegate->GetScenePrimPath(id, instance);
}

#endif

PXR_NAMESPACE_CLOSE_SCOPE
