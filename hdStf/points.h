// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/tessellatedPrim.h"

#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfPoints
///
/// Points as spheres (stfLib/surface/point_set.h).
///
/// Threading: as HdStfRprim.
class HdStfPoints final : public HdStfTessellatedPrim {
public:
    using HdStfTessellatedPrim::HdStfTessellatedPrim;

protected:
    bool _PullTopology(HdSceneDelegate* /*sceneDelegate*/, HdDirtyBits /*dirtyBits*/) override { return false; }
    size_t _CountOf(HdInterpolation interpolation) const override {
        return interpolation == HdInterpolationConstant || interpolation == HdInterpolationUniform ? 1 : _points.size();
    }
    stf::ControlMesh _Tessellate(std::string* problems) const override;
};

PXR_NAMESPACE_CLOSE_SCOPE
