// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hdStf/hydraCompat.h"

#include "pxr/imaging/hd/rendererPlugin.h"
#include "pxr/pxr.h"

PXR_NAMESPACE_OPEN_SCOPE

/// \class HdStfRendererPlugin
///
/// What Hydra's plugin registry finds: makes and deletes render delegates. Needs no GPU.
class HdStfRendererPlugin final : public HdRendererPlugin {
public:
    HdStfRendererPlugin() = default;

    HdRenderDelegate* CreateRenderDelegate() override;
    HdRenderDelegate* CreateRenderDelegate(HdRenderSettingsMap const& settingsMap) override;
    void DeleteRenderDelegate(HdRenderDelegate* renderDelegate) override;

#if HDSTF_IS_SUPPORTED_TAKES_SCHEMA
    bool IsSupported(HdRendererCreateArgsSchema const& /*args*/, std::string* /*reasonWhyNot*/) const override {
        return true;
    }
#elif HDSTF_IS_SUPPORTED_TAKES_ARGS
    bool IsSupported(HdRendererCreateArgs const& /*args*/, std::string* /*reasonWhyNot*/ = nullptr) const override {
        return true;
    }
#elif HDSTF_IS_SUPPORTED_TAKES_GPU_FLAG
    bool IsSupported(bool /*gpuEnabled*/ = true) const override {
        return true;
    }
#else
    bool IsSupported() const override {
        return true;
    }
#endif

private:
    HdStfRendererPlugin(HdStfRendererPlugin const&) = delete;
    HdStfRendererPlugin& operator=(HdStfRendererPlugin const&) = delete;
};

PXR_NAMESPACE_CLOSE_SCOPE
