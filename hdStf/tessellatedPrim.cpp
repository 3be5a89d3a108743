// SPDX-License-Identifier: Apache-2.0
#include "hdStf/tessellatedPrim.h"

#include "hdStf/material.h"
#include "hdStf/renderParam.h"
#include "hdStf/tokens.h"

#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

bool HdStfTessellatedPrim::_PullPrimvars(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits,
                                         HdStfMessages& messages) {
    SdfPath const& id = GetId();
    bool changed = false;
    if (HdChangeTracker::IsPrimvarDirty(dirtyBits, id, HdTokens->points)) {
        const VtVec3fArray points = HdStfPullPoints(id, sceneDelegate);
        changed = points != _points;
        _points = points;
    }
    const bool primvarsDirty = dirtyBits & HdChangeTracker::DirtyPrimvar;
    const bool widthsDirty = HdChangeTracker::IsPrimvarDirty(dirtyBits, id, HdTokens->widths);
    const bool normalsDirty = HdChangeTracker::IsPrimvarDirty(dirtyBits, id, HdTokens->normals);
    if (!primvarsDirty && !widthsDirty && !normalsDirty) {
        return changed;
    }
    HdStfPrimvarDescriptors descriptors;
    for (size_t i = 0; i < descriptors.size(); ++i) {
        descriptors[i] = GetPrimvarDescriptors(sceneDelegate, HdStfInterpolations[i]);
    }
    const auto countOf = [this](HdInterpolation interpolation) { return _CountOf(interpolation); };
    const auto pull = [&](TfToken const& name, auto& held) {
        std::decay_t<decltype(held)> fresh;
        for (HdPrimvarDescriptorVector const& list : descriptors) {
            for (HdPrimvarDescriptor const& primvar : list) {
                if (primvar.name != name || !fresh.values.empty()) {
                    continue;
                }
                if (!HdStfAsArray(GetPrimvar(sceneDelegate, name), &fresh.values)) {
                    messages.Report(stf::Severity::Error, id.GetString() + ": primvars:" + name.GetString() +
                                                              " has a type that cannot be used; it is ignored");
                }
                fresh.interpolation = HdStfInterpolationOf(descriptors, primvar, fresh.values.size(), countOf);
            }
        }
        changed |= !(fresh == held);
        held = fresh;
    };
    if (primvarsDirty) {
        pull(HdTokens->displayColor, _colors);
        for (HdPrimvarDescriptor const& primvar : descriptors[0]) {
            if (primvar.name == HdStfPrimvarTokens->baseVolume) {
                messages.Report(stf::Severity::Warning,
                                id.GetString() + ": only meshes have shells; primvars:stf:baseVolume is left out");
            }
        }
        if (HdStfFindShell(sceneDelegate, _GetMaterial())) {
            messages.Report(stf::Severity::Warning, id.GetString() + ": " + _GetMaterial().GetString() +
                                                        " is a shell, which only meshes have; shown is displayColor");
        }
    }
    if (widthsDirty) {
        pull(HdTokens->widths, _widths);
    }
    if (normalsDirty) {
        pull(HdTokens->normals, _normals);
    }
    return changed;
}

void HdStfTessellatedPrim::_PullShape(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, HdDirtyBits dirtyBits,
                                      _Changes& changes) {
    changes.mesh = _PullTopology(sceneDelegate, dirtyBits);
    changes.mesh |= _PullPrimvars(sceneDelegate, dirtyBits, param.GetMessages());
    if (HdChangeTracker::IsDisplayStyleDirty(dirtyBits, GetId())) {
        const int level = sceneDelegate->GetDisplayStyle(GetId()).refineLevel;
        changes.mesh |= level != _refineLevel;
        _refineLevel = level;
    }
    if (!changes.mesh) {
        return;
    }
    std::string problems;
    _mesh = _Tessellate(&problems);
    _hasFaces = !_mesh->faceVertexCounts.empty();
    if (!problems.empty()) {
        param.GetMessages().Report(stf::Severity::Warning, GetId().GetString() + ": " + problems);
    }
}

void HdStfTessellatedPrim::_SendShape(stf::Scene& scene, _Changes const& changes, HdStfMessages& /*messages*/) {
    if (changes.mesh && _mesh) {
        scene.setMesh(GetId().GetString(), std::move(*_mesh), 0);
        _mesh.reset();
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
