// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"
#include "hdStf/meshData.h"
#include "stfLib/render/scene.h"

#include "pxr/base/gf/matrix4d.h"
#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/mesh.h"
#include "pxr/pxr.h"

#include <optional>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStfRenderParam;

/// \class HdStfMesh
///
/// A mesh as stfLib takes it. Each Sync pulls what is dirty, compares it with what is held, and edits the scene only
/// where a value changed: a moved mesh is not sent again, and an edit to the same value restarts nothing.
///
/// Threading: Sync runs in parallel with that of other meshes; shared state is reached through the render param only.
/// SetDrawn is called from the execute thread, when no prim syncs.
class HdStfMesh final : public HdMesh {
public:
#if HDSTF_HAS_INSTANCER_ID_ARGUMENT
    HdStfMesh(SdfPath const& id, SdfPath const& instancerId) : HdMesh(id, instancerId) {}
#else
    explicit HdStfMesh(SdfPath const& id) : HdMesh(id) {}
#endif
    ~HdStfMesh() override = default;

    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
              TfToken const& reprToken) override;
    void Finalize(HdRenderParam* renderParam) override;

    /// Whether the render pass draws this mesh (its render tag and the collection). True if that is a change.
    bool SetDrawn(bool drawn, HdStfRenderParam& param);

protected:
    /// The material says which texture coordinates are read, also those of subsets, which come with the topology. Where
    /// primvars come, go or change their interpolation, normals may be among them; UsdImaging then says that primvars
    /// are dirty, and looks at normals only where those are.
    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override {
        if (bits & (HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyTopology)) {
            bits |= HdChangeTracker::DirtyPrimvar;
        }
        return bits & HdChangeTracker::DirtyPrimvar ? bits | HdChangeTracker::DirtyNormals : bits;
    }
    void _InitRepr(TfToken const& reprToken, HdDirtyBits* dirtyBits) override;

private:
    /// What of the scene's mesh has to be sent.
    struct _Changes {
        bool mesh = false;
        bool binding = false;
        bool instances = false;
        bool visible = false;
        bool primId = false;
        bool material = false;
        bool links = false;
        bool Any() const { return mesh || binding || instances || visible || primId || material || links; }
    };

    void _PullBinding(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, _Changes& changes);
    TfToken _PullMaterial(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits, HdStfMessages& messages,
                          _Changes& changes);
    void _PullInstances(HdSceneDelegate* sceneDelegate, stf::Shutter const& shutter, HdDirtyBits dirtyBits,
                        _Changes& changes);
    void _Send(HdStfRenderParam& param, _Changes changes);

    HdStfMeshData _data;
    std::optional<stf::StfBinding> _binding;
    GfMatrix4d _transform{1.0};
    std::vector<stf::MeshInstance> _instances;
    int _sentPrimId = -1;
    SdfPath _material;
    std::vector<std::string> _links; // of lights, that it belongs to
    bool _visible = true;
    bool _drawn = true;
    bool _inScene = false;
};

PXR_NAMESPACE_CLOSE_SCOPE
