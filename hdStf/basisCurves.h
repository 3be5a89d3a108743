// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/tessellatedPrim.h"

#include "pxr/imaging/hd/basisCurvesTopology.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfBasisCurves
///
/// Curves as tubes, or as ribbons where they have normals (stfLib/surface/curve_set.h).
///
/// Threading: as HdStfRprim.
class HdStfBasisCurves final : public HdStfTessellatedPrim {
public:
    using HdStfTessellatedPrim::HdStfTessellatedPrim;

protected:
    bool _PullTopology(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits) override;
    size_t _CountOf(HdInterpolation interpolation) const override;
    stf::ControlMesh _Tessellate(std::string* problems) const override;

private:
    HdBasisCurvesTopology _topology;
};

PXR_NAMESPACE_CLOSE_SCOPE
