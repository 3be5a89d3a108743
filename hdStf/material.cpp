// SPDX-License-Identifier: Apache-2.0
#include "hdStf/material.h"

#include "hdStf/materialNetwork.h"
#include "hdStf/renderParam.h"

#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/sceneDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

void HdStfMaterial::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
    const HdDirtyBits bits = *dirtyBits;
    *dirtyBits = Clean;
    if (!(bits & (DirtyParams | DirtyResource))) {
        return;
    }
    auto& param = *static_cast<HdStfRenderParam*>(renderParam);
    const auto description =
        HdStfReadMaterial(GetId(), sceneDelegate->GetMaterialResource(GetId()), param.GetMessages());
    const std::string id = GetId().GetString();
    const TfToken before = _uvPrimvar;
    const std::optional<stf::StfBinding> shellBefore = _shell;
    _shell = description ? description->shell : std::nullopt;
    if (description && !_shell) {
        _uvPrimvar = description->uvPrimvar;
        if (!_inScene || !(description->surface == _surface)) {
            _surface = description->surface;
            _inScene = true;
            param.AcquireSceneForEdit().setMaterial(id, _surface);
        }
    } else {
        _uvPrimvar = TfToken();
        Finalize(renderParam);
    }
    if (_uvPrimvar != before || !(_shell == shellBefore)) {
        // Which coordinates meshes take, and which shell, is theirs to pull, and they sync after materials.
        param.MarkAllDirty(sceneDelegate->GetRenderIndex(), HdChangeTracker::DirtyPrimvar);
    }
}

void HdStfMaterial::Finalize(HdRenderParam* renderParam) {
    if (_inScene) {
        static_cast<HdStfRenderParam*>(renderParam)->AcquireSceneForEdit().removeMaterial(GetId().GetString());
        _inScene = false;
    }
}

HdStfMaterial const* HdStfFindMaterial(HdSceneDelegate* sceneDelegate, SdfPath const& id) {
    return id.IsEmpty() ? nullptr
                        : static_cast<HdStfMaterial const*>(
                              sceneDelegate->GetRenderIndex().GetSprim(HdPrimTypeTokens->material, id));
}

std::optional<stf::StfBinding> HdStfFindShell(HdSceneDelegate* sceneDelegate, SdfPath const& id) {
    HdStfMaterial const* material = HdStfFindMaterial(sceneDelegate, id);
    return material ? material->GetShell() : std::nullopt;
}

PXR_NAMESPACE_CLOSE_SCOPE
