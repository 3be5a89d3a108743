// SPDX-License-Identifier: Apache-2.0
#include "hdStf/rprim.h"

#include "hdStf/conversions.h"
#include "hdStf/instancer.h"
#include "hdStf/renderParam.h"
#include "hdStf/scenePaths.h"

#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/imaging/hd/tokens.h"

#include <algorithm>
#include <map>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// Of more instances paths are not asked for: UsdImaging looks for each among all of them.
constexpr size_t _mostNamedInstances = 512;

std::vector<std::string> _ToStrings(VtArray<TfToken> const& tokens) {
    std::vector<std::string> strings;
    for (TfToken const& token : tokens) {
        strings.push_back(token.GetString());
    }
    std::sort(strings.begin(), strings.end());
    return strings;
}

/// Names instances by their paths in the scene; those of one path, and where there are too many, by their number.
void _NameInstances(HdSceneDelegate* sceneDelegate, SdfPath const& id, std::vector<stf::MeshInstance>& instances) {
    std::map<std::string, int> uses;
    for (stf::MeshInstance& instance : instances) {
        instance.name = instances.size() > _mostNamedInstances
                            ? id.GetString()
                            : HdStfScenePath(sceneDelegate, id, instance.instanceId).GetString();
        ++uses[instance.name];
    }
    for (stf::MeshInstance& instance : instances) {
        if (uses[instance.name] > 1) {
            instance.name += "[" + std::to_string(instance.instanceId) + "]";
        }
    }
}

} // namespace

TfTokenVector const& HdStfRprim::GetBuiltinPrimvarNames() const {
    static const TfTokenVector names = {HdTokens->points, HdTokens->normals, HdTokens->widths};
    return names;
}

HdDirtyBits HdStfRprim::GetInitialDirtyBitsMask() const {
    return HdChangeTracker::InitRepr | HdChangeTracker::DirtyPoints | HdChangeTracker::DirtyTopology |
           HdChangeTracker::DirtySubdivTags | HdChangeTracker::DirtyDisplayStyle | HdChangeTracker::DirtyNormals |
           HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyTransform | HdChangeTracker::DirtyVisibility |
           HdChangeTracker::DirtyInstancer | HdChangeTracker::DirtyInstanceIndex | HdChangeTracker::DirtyPrimID |
           HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyCategories | HdChangeTracker::DirtyWidths;
}

void HdStfRprim::_InitRepr(TfToken const& reprToken, HdDirtyBits* /*dirtyBits*/) {
    // A repr has to be there for Hydra; nothing is drawn through it.
    if (std::find_if(_reprs.begin(), _reprs.end(), _ReprComparator(reprToken)) == _reprs.end()) {
        _reprs.emplace_back(reprToken, HdReprSharedPtr());
    }
}

void HdStfRprim::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
                      TfToken const& /*reprToken*/) {
    auto& param = *static_cast<HdStfRenderParam*>(renderParam);
    SdfPath const& id = GetId();
    const HdDirtyBits bits = *dirtyBits;
    _Changes changes;

#if HDSTF_HAS_INSTANCER_SYNC
    _UpdateInstancer(sceneDelegate, dirtyBits);
    HdInstancer::_SyncInstancerAndParents(sceneDelegate->GetRenderIndex(), GetInstancerId());
#endif
    if (bits & HdChangeTracker::DirtyMaterialId) {
        const SdfPath material = sceneDelegate->GetMaterialId(id);
        changes.material = material != _material;
        _material = material;
    }
    _PullShape(sceneDelegate, param, bits, changes);
    _PullInstances(sceneDelegate, param.GetShutter(), bits, changes);
    if (bits & HdChangeTracker::DirtyCategories) {
        std::vector<std::string> links = _ToStrings(sceneDelegate->GetCategories(id));
        changes.links = links != _links;
        _links = std::move(links);
    }
    if (HdChangeTracker::IsVisibilityDirty(bits, id)) {
        _UpdateVisibility(sceneDelegate, dirtyBits);
        changes.visible = _visible != IsVisible();
        _visible = IsVisible();
    }
    changes.primId = GetPrimId() != _sentPrimId;

    _Send(param, changes);
    *dirtyBits &= ~HdChangeTracker::AllSceneDirtyBits;
}

void HdStfRprim::_PullInstances(HdSceneDelegate* sceneDelegate, stf::Shutter const& shutter, HdDirtyBits dirtyBits,
                                _Changes& changes) {
    SdfPath const& id = GetId();
    const bool transformDirty = HdChangeTracker::IsTransformDirty(dirtyBits, id);
    if (!transformDirty && !HdChangeTracker::IsInstancerDirty(dirtyBits, id) &&
        !HdChangeTracker::IsInstanceIndexDirty(dirtyBits, id) && !(dirtyBits & HdChangeTracker::DirtyCategories)) {
        return;
    }
    if (transformDirty) {
        _transform = sceneDelegate->GetTransform(id);
    }
    std::vector<stf::MeshInstance> instances;
    HdInstancer* instancer =
        GetInstancerId().IsEmpty() ? nullptr : sceneDelegate->GetRenderIndex().GetInstancer(GetInstancerId());
    if (GetInstancerId().IsEmpty()) {
        stf::MeshInstance instance = {HdStfToTransform(_transform), 0, {}, {}, {}};
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
            instances.push_back({HdStfToTransform(_transform * transform), static_cast<int32_t>(index), {}, {}, {}});
            for (auto const& [time, matrix] : motion[index]) {
                instances.back().motion.push_back({time, HdStfToTransform(_transform * matrix)});
            }
        }
        _NameInstances(sceneDelegate, id, instances);
        const std::vector<VtArray<TfToken>> links =
            static_cast<HdStfInstancer*>(instancer)->ComputeInstanceCategories(id);
        for (size_t i = 0; i < links.size() && i < instances.size(); ++i) {
            instances[i].links = _ToStrings(links[i]);
        }
    }
    for (stf::MeshInstance& instance : instances) {
        // Hosts give samples of what stands still as well, at times that go by when they were asked.
        if (std::all_of(instance.motion.begin(), instance.motion.end(),
                        [&](stf::TransformSample const& s) { return s.transform == instance.motion.front().transform; })) {
            instance.motion.clear();
        }
    }
    changes.instances = instances != _instances;
    _instances = std::move(instances);
}

void HdStfRprim::_Send(HdStfRenderParam& param, _Changes changes) {
    const std::string id = GetId().GetString();
    if (!_HasShape()) {
        if (_inScene) {
            param.AcquireSceneForEdit().removeMesh(id);
            _inScene = false;
        }
        return;
    }
    if (!_inScene) {
        changes = {true, true, true, true, true, true, true};
    }
    if (!changes.Any()) {
        return;
    }
    stf::Scene& scene = param.AcquireSceneForEdit();
    _inScene = true;
    _SendShape(scene, changes, param.GetMessages());
    if (changes.instances) {
        scene.setInstances(id, _instances);
    }
    if (changes.visible) {
        scene.setVisible(id, _visible && _drawn);
    }
    if (changes.material) {
        scene.setMeshMaterial(id, _material.GetString());
    }
    if (changes.links) {
        scene.setLinks(id, _links);
    }
    if (changes.primId) {
        _sentPrimId = GetPrimId();
        scene.setPrimId(id, _sentPrimId);
    }
}

bool HdStfRprim::SetDrawn(bool drawn, HdStfRenderParam& param) {
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

void HdStfRprim::Finalize(HdRenderParam* renderParam) {
    if (_inScene) {
        static_cast<HdStfRenderParam*>(renderParam)->AcquireSceneForEdit().removeMesh(GetId().GetString());
        _inScene = false;
    }
    HdRprim::Finalize(renderParam);
}

PXR_NAMESPACE_CLOSE_SCOPE
