// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/transform.h"
#include "stfLib/base/vec.h"
#include "stfLib/render/camera.h"

#include "pxr/base/gf/matrix4d.h"
#include "pxr/base/gf/vec2f.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/vt/array.h"
#include "pxr/pxr.h"

#include <algorithm>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Values of Gf and Vt as stfLib's plain ones.

inline stf::Vec3f HdStfToVec3f(GfVec3f const& v) {
    return {v[0], v[1], v[2]};
}
inline stf::Vec2f HdStfToVec2f(GfVec2f const& v) {
    return {v[0], v[1]};
}
inline stf::Transform HdStfToTransform(GfMatrix4d const& m) {
    return stf::Transform::fromRowMajor(m.GetArray());
}

inline stf::Matrix4 HdStfToMatrix4(GfMatrix4d const& m) {
    stf::Matrix4 result;
    std::copy(m.GetArray(), m.GetArray() + 16, result.begin());
    return result;
}

template<class T>
std::vector<T> HdStfToVector(VtArray<T> const& array) {
    return std::vector<T>(array.cbegin(), array.cend());
}
inline std::vector<stf::Vec3f> HdStfToVector(VtArray<GfVec3f> const& array) {
    std::vector<stf::Vec3f> result(array.size());
    std::transform(array.cbegin(), array.cend(), result.begin(), HdStfToVec3f);
    return result;
}
inline std::vector<stf::Vec2f> HdStfToVector(VtArray<GfVec2f> const& array) {
    std::vector<stf::Vec2f> result(array.size());
    std::transform(array.cbegin(), array.cend(), result.begin(), HdStfToVec2f);
    return result;
}

PXR_NAMESPACE_CLOSE_SCOPE
