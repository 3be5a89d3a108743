// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"
#include "stfLib/render/scene.h"

#include "pxr/base/gf/matrix4d.h"
#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/rprim.h"
#include "pxr/pxr.h"

#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStfMessages;
class HdStfRenderParam;

/// \class HdStfRprim
///
/// What is drawn, as one of stfLib's meshes. Each Sync pulls what is dirty, compares it with what is held, and edits
/// the scene only where a value changed: what moved is not sent again, and an edit to the same value restarts nothing.
/// What all prims have is here: instances, material, links of lights, visibility; their shape is the subclasses'.
///
/// Threading: Sync runs in parallel with that of other prims; shared state is reached through the render param only.
/// SetDrawn is called from the execute thread, when no prim syncs.
class HdStfRprim : public HdRprim {
public:
#if HDSTF_HAS_INSTANCER_ID_ARGUMENT
    HdStfRprim(SdfPath const& id, SdfPath const& instancerId) : HdRprim(id, instancerId) {}
#else
    explicit HdStfRprim(SdfPath const& id) : HdRprim(id) {}
#endif
    ~HdStfRprim() override = default;

    TfTokenVector const& GetBuiltinPrimvarNames() const override;
    HdDirtyBits GetInitialDirtyBitsMask() const override;
    void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
              TfToken const& reprToken) final;
    void Finalize(HdRenderParam* renderParam) override;

    /// Whether the render pass draws this prim (its render tag and the collection). True if that is a change.
    bool SetDrawn(bool drawn, HdStfRenderParam& param);

protected:
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

    /// Pulls what the shape depends on; the prim's own material is pulled already.
    virtual void _PullShape(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, HdDirtyBits dirtyBits,
                            _Changes& changes) = 0;
    /// Whether there is something to send.
    virtual bool _HasShape() const = 0;
    /// Sends mesh and binding, and what of the material is not the prim's own, where they changed.
    virtual void _SendShape(stf::Scene& scene, _Changes const& changes, HdStfMessages& messages) = 0;

    /// The material says which texture coordinates are read, also those of subsets, which come with the topology. Where
    /// primvars come, go or change their interpolation, normals and widths may be among them; UsdImaging then says that
    /// primvars are dirty, and looks at those only where they are.
    HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override {
        if (bits & (HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyTopology)) {
            bits |= HdChangeTracker::DirtyPrimvar;
        }
        return bits & HdChangeTracker::DirtyPrimvar
                   ? bits | HdChangeTracker::DirtyNormals | HdChangeTracker::DirtyWidths
                   : bits;
    }
    void _InitRepr(TfToken const& reprToken, HdDirtyBits* dirtyBits) override;

    SdfPath const& _GetMaterial() const {
        return _material;
    }

private:
    void _PullInstances(HdSceneDelegate* sceneDelegate, stf::Shutter const& shutter, HdDirtyBits dirtyBits,
                        _Changes& changes);
    void _Send(HdStfRenderParam& param, _Changes changes);

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
