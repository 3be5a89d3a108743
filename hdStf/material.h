// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/preview_surface.h"
#include "stfLib/render/stf_binding.h"

#include "pxr/base/tf/token.h"
#include "pxr/imaging/hd/material.h"
#include "pxr/pxr.h"

#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfMaterial
///
/// A material: its UsdPreviewSurface goes to the scene, where meshes without a shell find it by its path. The shell of
/// an StfShell node is kept for meshes to ask for, whose own primvars go before it; a surface without a material that
/// hdStf knows shows its displayColor.
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
    /// The shell that its StfShell node gives to meshes; nothing: it is no shell.
    std::optional<stf::StfBinding> const& GetShell() const { return _shell; }

private:
    stf::PreviewSurface _surface;
    TfToken _uvPrimvar;
    std::optional<stf::StfBinding> _shell;
    bool _inScene = false;
};

/// The material of that path; null where there is none.
HdStfMaterial const* HdStfFindMaterial(HdSceneDelegate* sceneDelegate, SdfPath const& id);
/// The shell that it gives to meshes, if any.
std::optional<stf::StfBinding> HdStfFindShell(HdSceneDelegate* sceneDelegate, SdfPath const& id);

PXR_NAMESPACE_CLOSE_SCOPE
