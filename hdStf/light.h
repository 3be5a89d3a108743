// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/render/light.h"

#include "pxr/imaging/hd/light.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

class HdStfMessages;

/// \class HdStfLight
///
/// A light of UsdLux: distant, dome, disk, rectangle, sphere or cylinder, with its shaping.
///
/// Threading: as for every sprim; the scene is edited through the gate, and only where something changed.
class HdStfLight final : public HdLight {
public:
    HdStfLight(SdfPath const& id, TfToken const& type) : HdLight(id), _type(type) {}
    ~HdStfLight() override = default;

    /// All light types a host may create.
    static TfTokenVector const& GetTypes();
    static bool IsLightType(TfToken const& type);

    void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
    void Finalize(HdRenderParam* renderParam) override;
    HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }

private:
    void _ReadParams(HdSceneDelegate* sceneDelegate, stf::Light& light) const;

    TfToken _type;
    stf::Light _light;
    bool _inScene = false;
};

PXR_NAMESPACE_CLOSE_SCOPE
