// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/base/vt/array.h"
#include "pxr/base/vt/value.h"
#include "pxr/imaging/hd/enums.h"
#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/pxr.h"

#include <array>
#include <limits>

PXR_NAMESPACE_OPEN_SCOPE

/// What of primvars is the same for all kinds of rprims.

constexpr std::array<HdInterpolation, 5> HdStfInterpolations = {HdInterpolationConstant, HdInterpolationUniform,
                                                                HdInterpolationVarying, HdInterpolationVertex,
                                                                HdInterpolationFaceVarying};

/// The descriptors of an rprim's primvars, one list per interpolation.
using HdStfPrimvarDescriptors = std::array<HdPrimvarDescriptorVector, HdStfInterpolations.size()>;

/// The interpolation of a primvar of that name with so many values. UsdImaging of 20.08 goes on naming a primvar under
/// the interpolations that it had before: the one counts whose number of values, \p countOf(interpolation), is nearest
/// (of two, the greater: it is values that are missing).
template<class CountOf>
HdInterpolation HdStfInterpolationOf(HdStfPrimvarDescriptors const& descriptors, HdPrimvarDescriptor const& primvar,
                                     size_t values, CountOf const& countOf) {
    HdInterpolation nearest = primvar.interpolation;
    size_t least = std::numeric_limits<size_t>::max();
    for (size_t i = 0; i < descriptors.size(); ++i) {
        for (HdPrimvarDescriptor const& other : descriptors[i]) {
            const size_t count = other.name == primvar.name ? countOf(HdStfInterpolations[i]) : 0;
            const size_t off = count > values ? count - values : values - count;
            if (other.name == primvar.name && (off < least || (off == least && count > values))) {
                least = off;
                nearest = HdStfInterpolations[i];
            }
        }
    }
    return nearest;
}

/// Values with the interpolation that they came with.
template<class T>
struct HdStfPrimvar {
    VtArray<T> values;
    HdInterpolation interpolation = HdInterpolationConstant;
    bool operator==(HdStfPrimvar const& other) const {
        return interpolation == other.interpolation && values == other.values;
    }
};

/// The value as an array of T, also from a single T; false if it is neither.
template<class T>
bool HdStfAsArray(VtValue const& value, VtArray<T>* array) {
    if (value.CanCast<VtArray<T>>()) {
        *array = VtValue::Cast<VtArray<T>>(value).template UncheckedGet<VtArray<T>>();
        return true;
    }
    if (value.CanCast<T>()) {
        *array = VtArray<T>(1, VtValue::Cast<T>(value).template UncheckedGet<T>());
        return true;
    }
    return false;
}

/// Points, also those that computations of the scene (skinning, for one) make. To be pulled once per change.
VtVec3fArray HdStfPullPoints(SdfPath const& id, HdSceneDelegate* sceneDelegate);

PXR_NAMESPACE_CLOSE_SCOPE
