// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"
#include "hdStf/motionSamples.h"

#include "pxr/base/gf/matrix4d.h"
#include "pxr/base/vt/array.h"
#include "pxr/base/vt/types.h"
#include "pxr/base/vt/value.h"
#include "pxr/imaging/hd/instancer.h"
#include "pxr/imaging/hd/types.h"
#include "pxr/pxr.h"

#include <mutex>

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfInstancer
///
/// Turns instance primvars (translate, rotate, scale, instanceTransform, under their old and new names) into one matrix
/// per instance of a prototype. Nested instancers are flattened: the parent's instances outermost.
///
/// Threading: ComputeInstanceTransforms is called from rprims that sync in parallel; primvars can be pulled only once
/// per change and are cached under a lock.
class HdStfInstancer final : public HdInstancer {
public:
#if HDSTF_HAS_INSTANCER_ID_ARGUMENT
    HdStfInstancer(HdSceneDelegate* delegate, SdfPath const& id, SdfPath const& parentId)
        : HdInstancer(delegate, id, parentId) {}
#else
    HdStfInstancer(HdSceneDelegate* delegate, SdfPath const& id) : HdInstancer(delegate, id) {}
#endif
    ~HdStfInstancer() override = default;

#if HDSTF_HAS_INSTANCER_SYNC
    void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
#endif

    /// One matrix per instance of \p prototypeId, instance to world (the prototype's own transform comes before).
    VtMatrix4dArray ComputeInstanceTransforms(SdfPath const& prototypeId);
    /// The collections that a prototype's instances belong to, in the same order; none where the scene does not tell
    /// instances apart, or they are nested.
    std::vector<VtArray<TfToken>> ComputeInstanceCategories(SdfPath const& prototypeId);

    /// Where each of those instances is when the shutter opens and when it closes, with the times; empty where all of
    /// them are at rest. What is sampled in between is left aside.
    std::vector<HdStfMatrixSamples> ComputeInstanceMotion(SdfPath const& prototypeId, stf::Shutter const& shutter);

    /// What the primvars of one instance are worth: scale, then rotate, then translate, after instanceTransform. Values
    /// may be of any of the types hosts use (Vec4f real first, quaternions, float or half or double); empty ones and
    /// indices beyond an array mean identity.
    struct Primvars {
        VtValue translate, rotate, scale, transform;
    };
    static GfMatrix4d ComputeTransform(Primvars const& primvars, size_t index);

private:
    /// Instancer and primvars at one time.
    struct _State {
        Primvars primvars;
        GfMatrix4d transform{1.0};
    };
    /// At the first and at the last sample, with their times.
    struct _Ends {
        _State first, last;
        double open = 0, close = 0;
    };
    enum class _When { Present, First, Last };
    VtMatrix4dArray _ComputeTransforms(SdfPath const& prototypeId, _When when, stf::Shutter const& shutter,
                                       double* open, double* close);
    _Ends _SampleEnds(stf::Shutter const& shutter);
    void _PullPrimvars(HdDirtyBits dirtyBits);
#if !HDSTF_HAS_INSTANCER_SYNC
    void _PullPrimvarsIfDirty();
#endif

    std::mutex _mutex;
    Primvars _primvars;
    bool _visible = true;
};

PXR_NAMESPACE_CLOSE_SCOPE
