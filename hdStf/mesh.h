// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"
#include "hdStf/meshData.h"
#include "hdStf/rprim.h"

#include "pxr/pxr.h"

#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfMesh
///
/// A polygon or subdivision mesh, with its shell and the materials of its subsets of faces.
///
/// Threading: as HdStfRprim.
class HdStfMesh final : public HdStfRprim {
public:
    using HdStfRprim::HdStfRprim;
    ~HdStfMesh() override = default;

protected:
    void _PullShape(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, HdDirtyBits dirtyBits,
                    _Changes& changes) override;
    bool _HasShape() const override { return !_data.IsEmpty(); }
    void _SendShape(stf::Scene& scene, _Changes const& changes, HdStfMessages& messages) override;

private:
    void _PullBinding(HdSceneDelegate* sceneDelegate, HdStfRenderParam& param, _Changes& changes);
    TfToken _PullParts(HdSceneDelegate* sceneDelegate, HdDirtyBits dirtyBits, HdStfMessages& messages,
                       _Changes& changes);

    HdStfMeshData _data;
    std::optional<stf::StfBinding> _binding;
};

PXR_NAMESPACE_CLOSE_SCOPE
