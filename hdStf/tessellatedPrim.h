// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/primvars.h"
#include "hdStf/rprim.h"
#include "stfLib/surface/control_mesh.h"

#include "pxr/base/gf/vec3f.h"
#include "pxr/pxr.h"

#include <optional>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfTessellatedPrim
///
/// Curves and points: points with a width, which become a mesh when they are synced. They are drawn plainly, with their
/// displayColor or material, and have no shell.
///
/// Threading: as HdStfRprim.
class HdStfTessellatedPrim : public HdStfRprim {
public:
    using HdStfRprim::HdStfRprim;

protected:
    /// So many triangles at most for one prim: about 400 MB with all that is made of them.
    static constexpr size_t _maxTriangles = 2'000'000;

    /// Pulls the topology, if the prim has one. True if it differs from what is held.
    virtual bool _PullTopology(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits) = 0;
    /// How many values a primvar of that interpolation has.
    virtual size_t _CountOf(HdInterpolation interpolation) const = 0;
    /// The mesh, maybe without faces; \p problems: what was left out, empty if nothing was.
    virtual stf::ControlMesh _Tessellate(std::string* problems) const = 0;

    void _PullShape(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, HdDirtyBits dirtyBits,
                    _Changes& changes) override;
    bool _HasShape() const override { return _hasFaces; }
    void _SendShape(stf::Scene& scene, _Changes const& changes, HdStfMessages& messages) override;

    VtVec3fArray _points;
    HdStfPrimvar<float> _widths;
    HdStfPrimvar<GfVec3f> _colors;
    HdStfPrimvar<GfVec3f> _normals;
    int _refineLevel = 0;

private:
    bool _PullPrimvars(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits, HdStfMessages& messages);

    std::optional<stf::ControlMesh> _mesh; // until it is sent
    bool _hasFaces = false;
};

PXR_NAMESPACE_CLOSE_SCOPE
