// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pxr/imaging/hd/material.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfMaterial
///
/// A material: accepted, so that bound networks raise no error, and not used. A shell is described by primvars, any
/// other surface by displayColor.
///
/// Threading: Sync touches nothing shared and may run in parallel.
class HdStfMaterial final : public HdMaterial {
public:
    explicit HdStfMaterial(SdfPath const& id) : HdMaterial(id) {}

    void Sync(HdSceneDelegate* /*delegate*/, HdRenderParam* /*renderParam*/, HdDirtyBits* dirtyBits) override {
        *dirtyBits = Clean;
    }
    HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
    /// Pure virtual in early versions, gone in later ones: hence no `override`.
    virtual void Reload() {}
};

PXR_NAMESPACE_CLOSE_SCOPE
