// SPDX-License-Identifier: Apache-2.0
#include "hdStf/basisCurves.h"

#include "hdStf/conversions.h"
#include "stfLib/surface/curve_set.h"

#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/imaging/hd/tokens.h"

PXR_NAMESPACE_OPEN_SCOPE

namespace {

// By name: not every OpenUSD has all of them as tokens.
stf::CurveSet::Basis _ToStfBasis(HdBasisCurvesTopology const& topology, bool* known) {
    *known = true;
    std::string const& basis = topology.GetCurveBasis().GetString();
    if (topology.GetCurveType() != HdTokens->cubic) {
        return stf::CurveSet::Basis::Linear;
    }
    if (basis == "bezier") {
        return stf::CurveSet::Basis::Bezier;
    }
    if (basis == "bspline") {
        return stf::CurveSet::Basis::BSpline;
    }
    *known = basis == "catmullRom";
    return *known ? stf::CurveSet::Basis::CatmullRom : stf::CurveSet::Basis::Linear;
}

stf::CurveSet::Wrap _ToStfWrap(std::string const& wrap) {
    return wrap == "periodic"    ? stf::CurveSet::Wrap::Periodic
           : wrap == "pinned"    ? stf::CurveSet::Wrap::Pinned
           : wrap == "segmented" ? stf::CurveSet::Wrap::Segmented
                                 : stf::CurveSet::Wrap::Nonperiodic;
}

stf::CurveSet::Interpolation _ToStfInterpolation(HdInterpolation interpolation) {
    switch (interpolation) {
    case HdInterpolationUniform:
        return stf::CurveSet::Interpolation::Uniform;
    case HdInterpolationVertex:
        return stf::CurveSet::Interpolation::Vertex;
    case HdInterpolationVarying:
    case HdInterpolationFaceVarying:
        return stf::CurveSet::Interpolation::Varying;
    default:
        return stf::CurveSet::Interpolation::Constant;
    }
}

template<class From, class To>
void _Convert(HdStfPrimvar<From> const& from, stf::CurveSet::Primvar<To>& to) {
    to.values = HdStfToVector(from.values);
    to.interpolation = _ToStfInterpolation(from.interpolation);
}

/// Basis, wrap and numbers alone.
stf::CurveSet _ToStfTopology(HdBasisCurvesTopology const& topology, bool* known) {
    stf::CurveSet curves;
    curves.basis = _ToStfBasis(topology, known);
    curves.wrap = _ToStfWrap(topology.GetCurveWrap().GetString());
    curves.vertexCounts = HdStfToVector(topology.GetCurveVertexCounts());
    return curves;
}

} // namespace

bool HdStfBasisCurves::_PullTopology(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits) {
    if (!HdChangeTracker::IsTopologyDirty(dirtyBits, GetId())) {
        return false;
    }
    const HdBasisCurvesTopology topology = sceneDelegate->GetBasisCurvesTopology(GetId());
    const bool changed = topology != _topology || topology.GetInvisibleCurves() != _topology.GetInvisibleCurves();
    _topology = topology;
    return changed;
}

size_t HdStfBasisCurves::_CountOf(HdInterpolation interpolation) const {
    if (interpolation == HdInterpolationVertex) {
        return _points.size();
    }
    bool known = true;
    return _ToStfTopology(_topology, &known).valueCount(_ToStfInterpolation(interpolation));
}

stf::ControlMesh HdStfBasisCurves::_Tessellate(std::string* problems) const {
    bool known = true;
    stf::CurveSet curves = _ToStfTopology(_topology, &known);
    curves.indices = HdStfToVector(_topology.GetCurveIndices());
    curves.hidden = HdStfToVector(_topology.GetInvisibleCurves());
    curves.points = HdStfToVector(_points);
    _Convert(_widths, curves.widths);
    _Convert(_colors, curves.colors);
    _Convert(_normals, curves.normals);
    stf::CurveRepairs repairs;
    stf::ControlMesh mesh = stf::tessellate(curves, _refineLevel, _maxTriangles, repairs);
    *problems = repairs.summary();
    if (!known) {
        *problems += std::string(problems->empty() ? "" : "; ") + "curves of basis \"" +
                     _topology.GetCurveBasis().GetString() + "\" are drawn as lines from point to point";
    }
    return mesh;
}

PXR_NAMESPACE_CLOSE_SCOPE
