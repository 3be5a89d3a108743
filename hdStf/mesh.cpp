// SPDX-License-Identifier: Apache-2.0
#include "hdStf/mesh.h"

#include "hdStf/bindingReader.h"
#include "hdStf/conversions.h"
#include "hdStf/instancer.h"
#include "hdStf/material.h"
#include "hdStf/renderParam.h"
#include "hdStf/tokens.h"

#include "pxr/base/tf/stringUtils.h"
#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/sceneDelegate.h"

#include <algorithm>

PXR_NAMESPACE_OPEN_SCOPE

HdDirtyBits HdStfMesh::GetInitialDirtyBitsMask() const {
    return HdChangeTracker::InitRepr | HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyTopology |
           HdChangeTracker::DirtySubdivTags | HdChangeTracker::DirtyDisplayStyle | HdChangeTracker::DirtyNormals |
           HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyTransform | HdChangeTracker::DirtyVisibility |
           HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex | HdChangeTracker::DirtyPrimID |
           HdChangeTracker::DirtyMaterialId;
}

void HdStfMesh::_InitRepr(TfToken const& reprToken, HdDirtyBits* /*dirtyBits*/) {
    // A repr has to be there for Hydra; nothing is drawn through it.
    if (std::find_if(_reprs.begin(), _reprs.end(), _ReprComparator(reprToken)) == _reprs.end()) {
        _reprs.emplace_back(reprToken, HdReprSharedPtr());
    }
}

void HdStfMesh::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
                     TfToken const& /*reprToken*/) {
    auto& param = *static_cast<HdStfRenderParam*>(renderParam);
    SdfPath const& id = GetId();
    const HdDirtyBits bits = *dirtyBits;
    _Changes changes;

#if HDSTF_HAS_INSTANCER_SYNC
    _UpdateInstancer(sceneDelegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(sceneDelegate->GetRenderIndex(), GetInstancerId());
#endif
    const TfToken uvPrimvar = _PullMaterial(sceneDelegate, bits, changes);
    changes.mesh = _data.Pull(*this, sceneDelegate, bits, uvPrimvar, param.GetMessages());
    if (bits & HdChangeTracker::DirtyPrimvar) {
        _PullBinding(sceneDelegate, param, changes);
    }
    _PullInstances(sceneDelegate, param.GetShutter(), bits, changes);
    if (HdChangeTracker::IsVisibilityDirty(bits, id)) {
        _UpdateVisibility(sceneDelegate, dirtyBits);
        changes.visible = _visible != IsVisible();
        _visible = IsVisible();
    }
    changes.primId = GetPrimId() != _sentPrimId;

    _Send(param, changes);
    *dirtyBits &= ~HdChangeTracker::AllSceneDirtyBits;
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
    std::optional<stf::StfBinding> binding = HdStfReadBinding(GetId(), primvars, param.GetMessages());
    changes.binding = !(binding == _binding);
    _binding = std::move(binding);
}

/// The primvar that the bound material's textures are read by.
TfToken HdStfMesh::_PullMaterial(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits, _Changes& changes) {
    if (dirtyBits & HdChangeTracker::DirtyMaterialId) {
        const SdfPath material = sceneDelegate->GetMaterialId(GetId());
        changes.material = material != _material;
        _material = material;
    }
    HdSprim* sprim =
        _material.IsEmpty() ? nullptr : sceneDelegate->GetRenderIndex().GetSprim(HdPrimTypeTokens->material, _material);
    return sprim ? static_cast<HdStfMaterial*>(sprim)->GetUvPrimvar() : TfToken();
}

void HdStfMesh::_PullInstances(HdSceneDelegate* sceneDelegate, stf::Shutter const& shutter, HdDirtyBits dirtyBits,
                               _Changes& changes) {
    SdfPath const& id = GetId();
    const bool transformDirty = HdChangeTracker::IsTransformDirty(dirtyBits, id);
    if (!transformDirty && !HdChangeTracker::IsInstancerDirty(dirtyBits, id) &&
        !HdChangeTracker::IsInstanceIndexDirty(dirtyBits, id)) {
        return;
    }
    if (transformDirty) {
        _transform = sceneDelegate->GetTransform(id);
    }
    std::vector<stf::MeshInstance> instances;
    HdInstancer* instancer =
        GetInstancerId().IsEmpty() ? nullptr : sceneDelegate->GetRenderIndex().GetInstancer(GetInstancerId());
    if (GetInstancerId().IsEmpty()) {
        stf::MeshInstance instance = {HdStfToTransform(_transform), 0, {}};
        if (shutter.blurs()) {
            for (auto const& [time, matrix] : HdStfSampleTransform(sceneDelegate, id, shutter)) {
                instance.motion.push_back({time, HdStfToTransform(matrix)});
            }
        }
        instances.push_back(std::move(instance));
    } else if (TF_VERIFY(instancer)) {
        const VtMatrix4dArray transforms = static_cast<HdStfInstancer*>(instancer)->ComputeInstanceTransforms(id);
        std::vector<HdStfMatrixSamples> motion;
        if (shutter.blurs()) {
            motion = static_cast<HdStfInstancer*>(instancer)->ComputeInstanceMotion(id, shutter);
        }
        motion.resize(transforms.size());
        instances.reserve(transforms.size());
        for (GfMatrix4d const& transform : transforms) {
            const size_t index = instances.size();
            instances.push_back({HdStfToTransform(_transform * transform), static_cast<int32_t>(index), {}});
            for (auto const& [time, matrix] : motion[index]) {
                instances.back().motion.push_back({time, HdStfToTransform(_transform * matrix)});
            }
        }
    }
    changes.instances = instances != _instances;
    _instances = std::move(instances);
}

void HdStfMesh::_Send(HdStfRenderParam& param, _Changes changes) {
    const std::string id = GetId().GetString();
    if (_data.IsEmpty()) {
        if (_inScene) {
            param.AcquireSceneForEdit().removeMesh(id);
            _inScene = false;
        }
        return;
    }
    if (!_inScene) {
        changes = {true, true, true, true, true, true};
    }
    if (!changes.Any()) {
        return;
    }
    stf::Scene& scene = param.AcquireSceneForEdit();
    _inScene = true;
    if (changes.mesh) {
        scene.setMesh(id, _data.MakeControlMesh(), _data.GetRefineLevel());
    }
    if (changes.binding) {
        scene.setStf(id, _binding);
    }
    if (changes.instances) {
        scene.setInstances(id, _instances);
    }
    if (changes.visible) {
        scene.setVisible(id, _visible && _drawn);
    }
    if (changes.material) {
        scene.setMeshMaterial(id, _material.GetString());
    }
    if (changes.primId) {
        _sentPrimId = GetPrimId();
        scene.setPrimId(id, _sentPrimId);
    }
}

bool HdStfMesh::SetDrawn(bool drawn, HdStfRenderParam& param) {
    if (drawn == _drawn) {
        return false;
    }
    _drawn = drawn;
    if (!_inScene) {
        return false;
    }
    param.AcquireSceneForEdit().setVisible(GetId().GetString(), _visible && _drawn);
    return true;
}

void HdStfMesh::Finalize(HdRenderParam* renderParam) {
    if (_inScene) {
        static_cast<HdStfRenderParam*>(renderParam)->AcquireSceneForEdit().removeMesh(GetId().GetString());
        _inScene = false;
    }
    HdMesh::Finalize(renderParam);
}

PXR_NAMESPACE_CLOSE_SCOPE
