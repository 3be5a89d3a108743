// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/primvars.h"
#include "stfLib/surface/control_mesh.h"

#include "pxr/base/gf/vec2f.h"
#include "pxr/base/gf/vec3f.h"
#include "pxr/base/vt/array.h"
#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/enums.h"
#include "pxr/imaging/hd/meshTopology.h"
#include "pxr/imaging/hd/rprim.h"
#include "pxr/pxr.h"
#include "pxr/usd/sdf/path.h"

#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStfMessages;

/// \class HdStfMeshData
///
/// The geometry of a mesh as Hydra delivers it (arrays are shared, not copied), and its translation to a ControlMesh.
///
/// Threading: none of its own; each mesh has one.
class HdStfMeshData {
public:
    /// Pulls what of the topology \p dirtyBits say is dirty; before Pull. True if it differs from what is held.
    bool PullTopology(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits);
    /// Makes parts of the faces whose subsets have another material than \p meshMaterial, one for each material. True
    /// if faces belong to other parts than before.
    bool AssignParts(SdfPath const& id, SdfPath const& meshMaterial, HdStfMessages& messages);
    /// Of parts from 1 on; part 0 has the mesh's.
    SdfPathVector const& GetPartMaterials() const { return _partMaterials; }
    /// Pulls points and primvars, each value once. True if something differs from what is held. Texture
    /// coordinates are the primvar \p uvPrimvar where there is one of that name, else what looks most like them.
    bool Pull(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits, TfToken const& uvPrimvar,
              HdStfMessages& messages);

    bool IsEmpty() const { return _topology.GetFaceVertexCounts().empty() || _points.empty(); }
    int GetRefineLevel() const { return _refineLevel; }
    stf::ControlMesh MakeControlMesh() const;

private:
    bool _PullPoints(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits);
    bool _PullPrimvars(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits,
                       TfToken const& uvPrimvar, HdStfMessages& messages);
    /// How many values a primvar of that interpolation has.
    size_t _CountOf(HdInterpolation interpolation) const;

    HdMeshTopology _topology;
    SdfPathVector _partMaterials;
    std::vector<int> _faceParts; // empty: there are no parts
    int _refineLevel = 0;
    VtVec3fArray _points;
    HdStfPrimvar<GfVec2f> _uvs;
    HdStfPrimvar<GfVec3f> _colors;
    HdStfPrimvar<GfVec3f> _normals;
    HdStfPrimvar<GfVec3f> _rest;
    HdStfPrimvar<GfVec3f> _orientation;
};

/// One index per face vertex into \p uvs, where face vertices of the same vertex and the same coordinates share an
/// entry: face-varying values arrive flattened, and would otherwise leave a seam along every edge. \p uvs shrinks to
/// the entries used.
std::vector<int> HdStfWeldUvs(VtIntArray const& faceVertexIndices, std::vector<stf::Vec2f>& uvs);

PXR_NAMESPACE_CLOSE_SCOPE
