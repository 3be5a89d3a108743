// SPDX-License-Identifier: Apache-2.0
#include "hdStf/instancer.h"

#include "pxr/base/gf/half.h"
#include "pxr/base/gf/matrix4d.h"
#include "pxr/base/gf/quatd.h"
#include "pxr/base/gf/quatf.h"
#include "pxr/base/gf/quath.h"
#include "pxr/base/gf/vec3d.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/gf/vec3h.h"
#include "pxr/base/gf/vec4d.h"
#include "pxr/base/gf/vec4f.h"
#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/renderIndex.h"
#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/imaging/hd/tokens.h"

#include <algorithm>
#include <string>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// The element of an array of T, converted; false if \p value is no such array or too short.
template<class T, class Result, class Convert>
bool _Element(VtValue const& value, size_t index, Result* result, Convert const& convert) {
    if (!value.IsHolding<VtArray<T>>()) {
        return false;
    }
    VtArray<T> const& array = value.UncheckedGet<VtArray<T>>();
    if (index >= array.size()) {
        return false;
    }
    *result = convert(array[index]);
    return true;
}

bool _Vector(VtValue const& value, size_t index, GfVec3d* result) {
    const auto convert = [](auto const& v) { return GfVec3d(v); };
    return _Element<GfVec3f>(value, index, result, convert) || _Element<GfVec3d>(value, index, result, convert) ||
           _Element<GfVec3h>(value, index, result, convert);
}

bool _Rotation(VtValue const& value, size_t index, GfQuatd* result) {
    const auto fromQuat = [](auto const& q) { return GfQuatd(q); };
    const auto fromVec4 = [](auto const& v) { return GfQuatd(v[0], v[1], v[2], v[3]); };
    return _Element<GfQuath>(value, index, result, fromQuat) || _Element<GfQuatf>(value, index, result, fromQuat) ||
           _Element<GfQuatd>(value, index, result, fromQuat) || _Element<GfVec4f>(value, index, result, fromVec4) ||
           _Element<GfVec4d>(value, index, result, fromVec4);
}

/// Where a primvar of that name belongs; null if it is none of the transforms. Both generations of names are accepted
/// in every version, as hosts differ.
VtValue* _Slot(HdStfInstancer::Primvars& primvars, std::string const& name) {
    if (name == "translate" || name == "hydra:instanceTranslations") {
        return &primvars.translate;
    }
    if (name == "rotate" || name == "hydra:instanceRotations") {
        return &primvars.rotate;
    }
    if (name == "scale" || name == "hydra:instanceScales") {
        return &primvars.scale;
    }
    if (name == "instanceTransform" || name == "hydra:instanceTransforms") {
        return &primvars.transform;
    }
    return nullptr;
}

} // namespace

GfMatrix4d HdStfInstancer::ComputeTransform(Primvars const& primvars, size_t index) {
    GfMatrix4d result(1.0);
    GfMatrix4d matrix(1.0);
    GfVec3d vector;
    GfQuatd rotation;
    if (_Element<GfMatrix4d>(primvars.transform, index, &matrix, [](GfMatrix4d const& m) { return m; })) {
        result = matrix;
    }
    if (_Vector(primvars.scale, index, &vector)) {
        result = result * GfMatrix4d(1.0).SetScale(vector);
    }
    if (_Rotation(primvars.rotate, index, &rotation) && rotation.GetLength() > 0) {
        result = result * GfMatrix4d(1.0).SetRotate(rotation.GetNormalized());
    }
    if (_Vector(primvars.translate, index, &vector)) {
        result = result * GfMatrix4d(1.0).SetTranslate(vector);
    }
    return result;
}

void HdStfInstancer::_PullPrimvars(HdDirtyBits dirtyBits) {
    SdfPath const& id = GetId();
    Primvars held; // of which those that are not there any more go
    std::swap(held, _primvars);
    for (HdPrimvarDescriptor const& primvar : GetDelegate()->GetPrimvarDescriptors(id, HdInterpolationInstance)) {
        std::string const& name = primvar.name.GetString();
        if (VtValue* slot = _Slot(_primvars, name)) {
            const bool dirty = HdChangeTracker::IsPrimvarDirty(dirtyBits, id, primvar.name);
            *slot = dirty ? GetDelegate()->Get(id, primvar.name) : *_Slot(held, name);
        }
    }
}

#if HDSTF_HAS_INSTANCER_SYNC
void HdStfInstancer::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* /*renderParam*/, HdDirtyBits* dirtyBits) {
    std::lock_guard<std::mutex> lock(_mutex);
    _UpdateInstancer(sceneDelegate, dirtyBits);
#if HDSTF_HAS_INSTANCER_VISIBILITY
    _visible = sceneDelegate->GetVisible(GetId()); // not all versions say when it changes
#endif
    if (HdChangeTracker::IsAnyPrimvarDirty(*dirtyBits, GetId())) {
        _PullPrimvars(*dirtyBits);
    }
}
#else
void HdStfInstancer::_PullPrimvarsIfDirty() {
    HdChangeTracker& tracker = GetDelegate()->GetRenderIndex().GetChangeTracker();
    std::lock_guard<std::mutex> lock(_mutex);
    const HdDirtyBits dirtyBits = tracker.GetInstancerDirtyBits(GetId());
    if (HdChangeTracker::IsAnyPrimvarDirty(dirtyBits, GetId())) {
        _PullPrimvars(dirtyBits);
        tracker.MarkInstancerClean(GetId());
    }
}
#endif

std::vector<VtArray<TfToken>> HdStfInstancer::ComputeInstanceCategories(SdfPath const& prototypeId) {
    std::vector<VtArray<TfToken>> chosen;
    const std::vector<VtArray<TfToken>> all = GetDelegate()->GetInstanceCategories(GetId());
    if (all.empty() || !_visible || !GetParentId().IsEmpty()) {
        return chosen;
    }
    for (const int index : GetDelegate()->GetInstanceIndices(GetId(), prototypeId)) {
        const bool known = index >= 0 && static_cast<size_t>(index) < all.size();
        chosen.push_back(known ? all[static_cast<size_t>(index)] : VtArray<TfToken>());
    }
    return chosen;
}

VtMatrix4dArray HdStfInstancer::ComputeInstanceTransforms(SdfPath const& prototypeId) {
    return _ComputeTransforms(prototypeId, _When::Present, {}, nullptr, nullptr);
}

std::vector<HdStfMatrixSamples> HdStfInstancer::ComputeInstanceMotion(SdfPath const& prototypeId,
                                                                      stf::Shutter const& shutter) {
    double open = 0;
    double close = 0;
    const VtMatrix4dArray first = _ComputeTransforms(prototypeId, _When::First, shutter, &open, &close);
    const VtMatrix4dArray last = _ComputeTransforms(prototypeId, _When::Last, shutter, &open, &close);
    std::vector<HdStfMatrixSamples> motion;
    if (open < close && first.size() == last.size() && first != last) {
        motion.resize(first.size());
        for (size_t i = 0; i < first.size(); ++i) {
            if (first[i] != last[i]) {
                motion[i] = {{open, first[i]}, {close, last[i]}};
            }
        }
    }
    return motion;
}

HdStfInstancer::_Ends HdStfInstancer::_SampleEnds(stf::Shutter const& shutter) {
    SdfPath const& id = GetId();
    _Ends ends;
    std::lock_guard<std::mutex> lock(_mutex);
    ends.first.primvars = ends.last.primvars = _primvars;
    const HdStfMatrixSamples transforms = HdStfSampleInstancerTransform(GetDelegate(), id, shutter);
    ends.first.transform = ends.last.transform = GetDelegate()->GetInstancerTransform(id);
    if (!transforms.empty()) {
        ends.first.transform = transforms.front().second;
        ends.last.transform = transforms.back().second;
        ends.open = transforms.front().first;
        ends.close = transforms.back().first;
    }
    for (HdPrimvarDescriptor const& primvar : GetDelegate()->GetPrimvarDescriptors(id, HdInterpolationInstance)) {
        VtValue* first = _Slot(ends.first.primvars, primvar.name.GetString());
        if (!first) {
            continue;
        }
        HdTimeSampleArray<VtValue, 16> samples;
        const auto sizesDiffer = [&samples] {
            return samples.count < 2 ||
                   samples.values[0].GetArraySize() != samples.values[samples.count - 1].GetArraySize();
        };
        VtValue* last = _Slot(ends.last.primvars, primvar.name.GetString());
#if HDSTF_HAS_SAMPLING_INTERVAL
        const float open = static_cast<float>(shutter.open);
        const float close = static_cast<float>(shutter.close);
        GetDelegate()->SamplePrimvar(id, primvar.name, open, close, &samples);
        if (sizesDiffer()) {
            continue;
        }
        // Samples may be those authored before and after.
        *first = samples.Resample(open);
        *last = samples.Resample(close);
        ends.open = std::min(ends.open, shutter.open);
        ends.close = std::max(ends.close, shutter.close);
#else
        GetDelegate()->SamplePrimvar(id, primvar.name, &samples);
        if (sizesDiffer()) {
            continue;
        }
        const auto [open, close] = std::minmax_element(samples.times.begin(), samples.times.begin() + samples.count);
        if (!(*open < *close)) {
            continue;
        }
        *first = samples.values[static_cast<size_t>(open - samples.times.begin())];
        *last = samples.values[static_cast<size_t>(close - samples.times.begin())];
        ends.open = std::min(ends.open, static_cast<double>(*open));
        ends.close = std::max(ends.close, static_cast<double>(*close));
#endif
    }
    return ends;
}

VtMatrix4dArray HdStfInstancer::_ComputeTransforms(SdfPath const& prototypeId, _When when, stf::Shutter const& shutter,
                                                   double* open, double* close) {
#if !HDSTF_HAS_INSTANCER_SYNC
    _PullPrimvarsIfDirty();
#endif
    _State state;
    if (when == _When::Present) {
        state = {_primvars, GetDelegate()->GetInstancerTransform(GetId())};
    } else {
        const _Ends ends = _SampleEnds(shutter);
        state = when == _When::First ? ends.first : ends.last;
        *open = std::min(*open, ends.open);
        *close = std::max(*close, ends.close);
    }
    const VtIntArray indices = _visible ? GetDelegate()->GetInstanceIndices(GetId(), prototypeId) : VtIntArray();
    VtMatrix4dArray transforms(indices.size());
    GfMatrix4d* own = transforms.data();
    for (size_t i = 0; i < indices.size(); ++i) {
        const size_t index = static_cast<size_t>(indices[i]);
        own[i] = ComputeTransform(state.primvars, index) * state.transform;
    }

    if (GetParentId().IsEmpty()) {
        return transforms;
    }
    HdInstancer* parent = GetDelegate()->GetRenderIndex().GetInstancer(GetParentId());
    if (!TF_VERIFY(parent)) {
        return transforms;
    }
    const VtMatrix4dArray outer =
        static_cast<HdStfInstancer*>(parent)->_ComputeTransforms(GetId(), when, shutter, open, close);
    VtMatrix4dArray flat(outer.size() * transforms.size());
    GfMatrix4d* result = flat.data();
    for (GfMatrix4d const& parentTransform : outer) {
        for (GfMatrix4d const& transform : transforms) {
            *result++ = transform * parentTransform;
        }
    }
    return flat;
}

PXR_NAMESPACE_CLOSE_SCOPE
