// SPDX-License-Identifier: Apache-2.0
#include "hdStf/meshData.h"

#include "hdStf/conversions.h"
#include "hdStf/messages.h"
#include "hdStf/tokens.h"

#include "pxr/imaging/hd/changeTracker.h"
#include "pxr/imaging/hd/sceneDelegate.h"
#include "pxr/imaging/hd/tokens.h"
#include "pxr/imaging/pxOsd/tokens.h"

#include <algorithm>
#include <map>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// How much a primvar looks like the texture coordinates: 0 not at all, the higher the better.
int _UvRank(HdPrimvarDescriptor const& primvar, TfToken const& wanted) {
    if (!wanted.IsEmpty() && primvar.name == wanted) {
        return 10;
    }
    static char const* const names[] = {"UVMap", "st0", "uv", "st"};
    for (int i = 0; i < 4; ++i) {
        if (primvar.name == names[i]) {
            return i + 2;
        }
    }
    return primvar.role == HdPrimvarRoleTokens->textureCoordinate ? 1 : 0;
}

stf::ControlMesh::Interpolation _ToStf(HdInterpolation interpolation) {
    switch (interpolation) {
    case HdInterpolationUniform:
        return stf::ControlMesh::Interpolation::Uniform;
    case HdInterpolationVarying:
    case HdInterpolationVertex:
        return stf::ControlMesh::Interpolation::Vertex;
    case HdInterpolationFaceVarying:
        return stf::ControlMesh::Interpolation::FaceVarying;
    default:
        return stf::ControlMesh::Interpolation::Constant;
    }
}

stf::ControlMesh::Scheme _ToStfScheme(TfToken const& scheme) {
    if (scheme == PxOsdOpenSubdivTokens->catmullClark) {
        return stf::ControlMesh::Scheme::CatmullClark;
    }
    if (scheme == PxOsdOpenSubdivTokens->loop) {
        return stf::ControlMesh::Scheme::Loop;
    }
    if (scheme == PxOsdOpenSubdivTokens->bilinear) {
        return stf::ControlMesh::Scheme::Bilinear;
    }
    return stf::ControlMesh::Scheme::None;
}

} // namespace

std::vector<int> HdStfWeldUvs(VtIntArray const& faceVertexIndices, std::vector<stf::Vec2f>& uvs) {
    std::map<std::pair<int, std::pair<float, float>>, int> entries;
    std::vector<stf::Vec2f> welded;
    std::vector<int> indices;
    indices.reserve(uvs.size());
    for (size_t i = 0; i < uvs.size(); ++i) {
        const auto [it, isNew] =
            entries.try_emplace({faceVertexIndices.cdata()[i], {uvs[i].x, uvs[i].y}}, static_cast<int>(welded.size()));
        if (isNew) {
            welded.push_back(uvs[i]);
        }
        indices.push_back(it->second);
    }
    uvs = std::move(welded);
    return indices;
}

bool HdStfMeshData::Pull(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits,
                         TfToken const& uvPrimvar, HdStfMessages& messages) {
    bool changed = _PullPoints(mesh, sceneDelegate, dirtyBits);
    changed |= _PullPrimvars(mesh, sceneDelegate, dirtyBits, uvPrimvar, messages);
    return changed;
}

bool HdStfMeshData::PullTopology(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits) {
    SdfPath const& id = mesh.GetId();
    bool changed = false;
    const bool topologyDirty = HdChangeTracker::IsTopologyDirty(dirtyBits, id);
    if (topologyDirty || HdChangeTracker::IsSubdivTagsDirty(dirtyBits, id)) {
        HdMeshTopology topology = topologyDirty ? sceneDelegate->GetMeshTopology(id) : _topology;
        topology.SetSubdivTags(sceneDelegate->GetSubdivTags(id));
        changed = !(topology == _topology);
        _topology = topology;
    }
    if (HdChangeTracker::IsDisplayStyleDirty(dirtyBits, id)) {
        const int level = sceneDelegate->GetDisplayStyle(id).refineLevel;
        changed |= level != _refineLevel;
        _refineLevel = level;
    }
    return changed;
}

bool HdStfMeshData::AssignParts(SdfPath const& id, SdfPath const& meshMaterial, HdStfMessages& messages) {
    const size_t faces = _topology.GetFaceVertexCounts().size();
    SdfPathVector materials;
    std::vector<int> parts;
    for (HdGeomSubset const& subset : _topology.GetGeomSubsets()) {
        if (subset.type != HdGeomSubset::TypeFaceSet || subset.materialId.IsEmpty() ||
            subset.materialId == meshMaterial) {
            continue;
        }
        const auto known = std::find(materials.begin(), materials.end(), subset.materialId);
        const int part = static_cast<int>(known - materials.begin()) + 1;
        if (known == materials.end()) {
            materials.push_back(subset.materialId);
        }
        parts.resize(faces, 0);
        size_t outside = 0;
        for (const int face : subset.indices) {
            if (face < 0 || static_cast<size_t>(face) >= faces) {
                ++outside;
            } else if (parts[static_cast<size_t>(face)] == 0) { // a face of several subsets is the first one's
                parts[static_cast<size_t>(face)] = part;
            }
        }
        if (outside > 0) {
            messages.Report(stf::Severity::Warning, id.GetString() + ": subset " + subset.id.GetName() + " names " +
                                                        std::to_string(outside) + " faces that the mesh does not have");
        }
    }
    const bool changed = parts != _faceParts;
    _faceParts = std::move(parts);
    _partMaterials = std::move(materials);
    return changed;
}

bool HdStfMeshData::_PullPoints(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits) {
    SdfPath const& id = mesh.GetId();
    if (!HdChangeTracker::IsPrimvarDirty(dirtyBits, id, HdTokens->points)) {
        return false;
    }
    const VtVec3fArray points = HdStfPullPoints(id, sceneDelegate);
    const bool changed = points != _points;
    _points = points;
    return changed;
}

size_t HdStfMeshData::_CountOf(HdInterpolation interpolation) const {
    switch (interpolation) {
    case HdInterpolationConstant:
        return 1;
    case HdInterpolationUniform:
        return _topology.GetFaceVertexCounts().size();
    case HdInterpolationFaceVarying:
        return _topology.GetFaceVertexIndices().size();
    default:
        return _points.size();
    }
}

bool HdStfMeshData::_PullPrimvars(HdRprim const& mesh, HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits,
                                  TfToken const& uvPrimvar, HdStfMessages& messages) {
    SdfPath const& id = mesh.GetId();
    const bool primvarsDirty = dirtyBits & HdChangeTracker::DirtyPrimvar;
    const bool normalsDirty = HdChangeTracker::IsPrimvarDirty(dirtyBits, id, HdTokens->normals);
    if (!primvarsDirty && !normalsDirty) {
        return false;
    }

    // Subdivided meshes have normals of their own, and their hosts may name authored ones without having them.
    const bool hasNormals = _ToStfScheme(_topology.GetScheme()) == stf::ControlMesh::Scheme::None;
    HdPrimvarDescriptor const* uv = nullptr;
    HdPrimvarDescriptor const* color = nullptr;
    HdPrimvarDescriptor const* normal = nullptr;
    HdPrimvarDescriptor const* rest = nullptr;
    HdPrimvarDescriptor const* orientation = nullptr;
    HdStfPrimvarDescriptors descriptors;
    for (size_t i = 0; i < HdStfInterpolations.size(); ++i) {
        descriptors[i] = mesh.GetPrimvarDescriptors(sceneDelegate, HdStfInterpolations[i]);
        for (HdPrimvarDescriptor const& primvar : descriptors[i]) {
            if (primvar.name == HdTokens->displayColor) {
                color = &primvar;
            } else if (primvar.name == HdTokens->normals) {
                normal = hasNormals ? &primvar : nullptr;
            } else if (primvar.name == HdStfPrimvarTokens->rest) {
                rest = &primvar;
            } else if (primvar.name == HdStfPrimvarTokens->orientation) {
                orientation = &primvar;
            } else if (primvar.interpolation != HdInterpolationConstant &&
                       primvar.interpolation != HdInterpolationUniform && _UvRank(primvar, uvPrimvar) > 0) {
                const bool better = !uv || _UvRank(primvar, uvPrimvar) > _UvRank(*uv, uvPrimvar) ||
                                    (_UvRank(primvar, uvPrimvar) == _UvRank(*uv, uvPrimvar) &&
                                     primvar.name.GetString() < uv->name.GetString());
                uv = better ? &primvar : uv;
            }
        }
    }

    const auto countOf = [this](HdInterpolation interpolation) { return _CountOf(interpolation); };
    const auto pull = [&](HdPrimvarDescriptor const* primvar, auto& held) {
        std::decay_t<decltype(held)> fresh;
        if (primvar) {
            if (!HdStfAsArray(mesh.GetPrimvar(sceneDelegate, primvar->name), &fresh.values)) {
                messages.Report(stf::Severity::Error, id.GetString() + ": primvars:" + primvar->name.GetString() +
                                                          " has a type that cannot be used; it is ignored");
            }
            fresh.interpolation = HdStfInterpolationOf(descriptors, *primvar, fresh.values.size(), countOf);
        }
        const bool changed = !(fresh == held);
        held = fresh;
        return changed;
    };
    bool changed = false;
    if (primvarsDirty) {
        changed |= pull(uv, _uvs);
        changed |= pull(color, _colors);
        changed |= pull(rest, _rest);
        changed |= pull(orientation, _orientation);
    }
    if (normalsDirty) {
        changed |= pull(normal, _normals);
    }
    return changed;
}

stf::ControlMesh HdStfMeshData::MakeControlMesh() const {
    stf::ControlMesh mesh;
    mesh.faceVertexCounts = HdStfToVector(_topology.GetFaceVertexCounts());
    mesh.faceVertexIndices = HdStfToVector(_topology.GetFaceVertexIndices());
    mesh.holeIndices = HdStfToVector(_topology.GetHoleIndices());
    mesh.holeIndices.insert(mesh.holeIndices.end(), _topology.GetInvisibleFaces().cbegin(),
                            _topology.GetInvisibleFaces().cend());
    mesh.faceParts = _faceParts;
    mesh.points = HdStfToVector(_points);
    mesh.scheme = _ToStfScheme(_topology.GetScheme());
    mesh.leftHanded = _topology.GetOrientation() == PxOsdOpenSubdivTokens->leftHanded;

    PxOsdSubdivTags const& tags = _topology.GetSubdivTags();
    mesh.cornerIndices = HdStfToVector(tags.GetCornerIndices());
    mesh.cornerSharpnesses = HdStfToVector(tags.GetCornerWeights());
    mesh.creaseIndices = HdStfToVector(tags.GetCreaseIndices());
    mesh.creaseLengths = HdStfToVector(tags.GetCreaseLengths());
    mesh.creaseSharpnesses = HdStfToVector(tags.GetCreaseWeights());
    if (!tags.GetVertexInterpolationRule().IsEmpty()) {
        mesh.interpolateBoundary = tags.GetVertexInterpolationRule().GetString();
    }
    if (!tags.GetFaceVaryingInterpolationRule().IsEmpty()) {
        mesh.faceVaryingInterpolation = tags.GetFaceVaryingInterpolationRule().GetString();
    }

    VtIntArray const& faceVertices = _topology.GetFaceVertexIndices();
    mesh.uvs = HdStfToVector(_uvs.values);
    if (_uvs.interpolation != HdInterpolationFaceVarying) {
        mesh.uvIndices = mesh.uvs.empty() ? std::vector<int>() : mesh.faceVertexIndices;
    } else if (mesh.uvs.size() == faceVertices.size()) {
        mesh.uvIndices = HdStfWeldUvs(faceVertices, mesh.uvs);
    } else {
        // Left for `sanitize` to find: as many indices as values, which is not one per face vertex.
        mesh.uvIndices.resize(mesh.uvs.size());
    }

    mesh.colors = HdStfToVector(_colors.values);
    mesh.colorInterpolation = _ToStf(_colors.interpolation);
    mesh.rest = HdStfToVector(_rest.values);
    mesh.orientation = HdStfToVector(_orientation.values);
    // An array for a constant is one that was authored without saying its interpolation.
    const bool perPoint = _orientation.interpolation == HdInterpolationConstant && mesh.orientation.size() > 1;
    mesh.orientationInterpolation =
        perPoint ? stf::ControlMesh::Interpolation::Vertex : _ToStf(_orientation.interpolation);
    if (mesh.scheme == stf::ControlMesh::Scheme::None) {
        mesh.normals = HdStfToVector(_normals.values);
        mesh.normalInterpolation = _ToStf(_normals.interpolation);
    }
    return mesh;
}

PXR_NAMESPACE_CLOSE_SCOPE
