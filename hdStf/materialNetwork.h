// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/messages.h"
#include "stfLib/render/preview_surface.h"
#include "stfLib/render/stf_binding.h"

#include "pxr/base/tf/token.h"
#include "pxr/base/vt/value.h"
#include "pxr/pxr.h"
#include "pxr/usd/sdf/path.h"

#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

/// What hdStf takes from a material.
struct HdStfMaterialDescription {
    stf::PreviewSurface surface;
    std::optional<stf::StfBinding> shell; ///< of an StfShell node; `surface` then says nothing
    TfToken uvPrimvar;                    ///< that its textures are read by; empty: none of them says
};

/// Reads the surface of an HdMaterialNetworkMap: UsdPreviewSurface, with UsdUVTexture, UsdTransform2d and
/// UsdPrimvarReader nodes behind its inputs, or StfShell. Nothing where there is no surface that hdStf knows; what is
/// not understood is reported once with the material's path. Pure but for the messages: any thread.
std::optional<HdStfMaterialDescription> HdStfReadMaterial(SdfPath const& id, VtValue const& resource,
                                                          HdStfMessages& messages);

PXR_NAMESPACE_CLOSE_SCOPE
