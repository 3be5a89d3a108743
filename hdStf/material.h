// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/preview_surface.h"

#include "pxr/base/tf/token.h"
#include "pxr/imaging/hd/material.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfMaterial
///
/// A material: its UsdPreviewSurface goes to the scene, where meshes without a shell find it by its path. A shell is
/// described by primvars; a surface without a material that hdStf knows shows its displayColor.
///
/// Threading: Sync may run in parallel with that of other prims; shared state is reached through the render param.
/// Meshes are synced after materials.
class HdStfMaterial final : public HdMaterial {
public:
    explicit HdStfMaterial(SdfPath const& id) : HdMaterial(id) {}

    void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;
    HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
    /// Pure virtual in early versions, gone in later ones: hence no `override`.
    virtual void Reload() {}

    /// The primvar that its textures are read by; empty: none of them says.
    TfToken const& GetUvPrimvar() const { return _uvPrimvar; }

private:
    stf::PreviewSurface _surface;
    TfToken _uvPrimvar;
    bool _inScene = false;
};

PXR_NAMESPACE_CLOSE_SCOPE
