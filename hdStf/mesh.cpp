// SPDX-License-Identifier: Apache-2.0
#include "hdStf/mesh.h"

#include "hdStf/bindingReader.h"
#include "hdStf/material.h"
#include "hdStf/renderParam.h"
#include "hdStf/tokens.h"

#include "pxr/base/tf/stringUtils.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/sceneDelegate.h"

PXR_NAMESPACE_OPEN_SCOPE

void HdStfMesh::_PullShape(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, HdDirtyBits dirtyBits,
                           _Changes& changes) {
    changes.mesh = _data.PullTopology(*this, sceneDelegate, dirtyBits);
    const TfToken uvPrimvar = _PullParts(sceneDelegate, dirtyBits, param.GetMessages(), changes);
    changes.mesh |= _data.Pull(*this, sceneDelegate, dirtyBits, uvPrimvar, param.GetMessages());
    if (dirtyBits & HdChangeTracker::DirtyPrimvar) {
        _PullBinding(sceneDelegate, param, changes);
    }
    if (_binding && !_data.GetPartMaterials().empty()) {
        param.GetMessages().Report(stf::Severity::Warning,
                                   GetId().GetString() + ": a mesh with a shell is one whole; the materials of its " +
                                       "subsets of faces are left out");
    }
}

void HdStfMesh::_PullBinding(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, _Changes& changes) {
    std::vector<std::pair<TfToken, VtValue>> primvars;
    for (HdPrimvarDescriptor const& primvar : GetPrimvarDescriptors(sceneDelegate, HdInterpolationConstant)) {
        // A value is there for one pull only: what belongs to the points is the mesh data's.
        const bool ofPoints =
            primvar.name == HdStfPrimvarTokens->rest || primvar.name == HdStfPrimvarTokens->orientation;
        if (!ofPoints && TfStringStartsWith(primvar.name.GetString(), HdStfPrimvarTokens->prefix.GetString())) {
            primvars.emplace_back(primvar.name, GetPrimvar(sceneDelegate, primvar.name));
        }
    }
    std::optional<stf::StfBinding> binding =
        HdStfReadBinding(GetId(), primvars, param.GetMessages(), HdStfBindingSource::Primvars,
                         HdStfFindShell(sceneDelegate, _GetMaterial()));
    for (SdfPath const& material : _data.GetPartMaterials()) {
        if (HdStfFindShell(sceneDelegate, material)) {
            param.GetMessages().Report(stf::Severity::Warning, GetId().GetString() + ": " + material.GetString() +
                                                                   " of a subset is a shell, which only whole meshes " +
                                                                   "have; its faces show their displayColor");
        }
    }
    changes.binding = !(binding == _binding);
    _binding = std::move(binding);
}

/// The primvar that the bound materials' textures are read by.
TfToken HdStfMesh::_PullParts(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits, HdStfMessages& messages,
                              _Changes& changes) {
    if (dirtyBits & (HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyTopology)) {
        const SdfPathVector before = _data.GetPartMaterials();
        changes.mesh |= _data.AssignParts(GetId(), _GetMaterial(), messages);
        changes.material |= before != _data.GetPartMaterials();
    }
    const auto uvPrimvarOf = [&](SdfPath const& id) {
        HdStfMaterial const* material = HdStfFindMaterial(sceneDelegate, id);
        return material ? material->GetUvPrimvar() : TfToken();
    };
    TfToken uvPrimvar = uvPrimvarOf(_GetMaterial());
    for (SdfPath const& id : _data.GetPartMaterials()) {
        const TfToken other = uvPrimvarOf(id);
        if (uvPrimvar.IsEmpty()) {
            uvPrimvar = other;
        } else if (!other.IsEmpty() && other != uvPrimvar) {
            messages.Report(stf::Severity::Error, GetId().GetString() + ": " + id.GetString() + " of a subset reads " +
                                                      other.GetString() + " beside " + uvPrimvar.GetString() +
                                                      "; a mesh has one set of coordinates");
        }
    }
    return uvPrimvar;
}

void HdStfMesh::_SendShape(stf::Scene& scene, _Changes const& changes, HdStfMessages& /*messages*/) {
    const std::string id = GetId().GetString();
    if (changes.mesh) {
        scene.setMesh(id, _data.MakeControlMesh(), _data.GetRefineLevel());
    }
    if (changes.binding) {
        scene.setStf(id, _binding);
    }
    if (changes.material) {
        std::vector<std::string> parts;
        for (SdfPath const& material : _data.GetPartMaterials()) {
            parts.push_back(material.GetString());
        }
        scene.setPartMaterials(id, std::move(parts));
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
