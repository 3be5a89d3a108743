// SPDX-License-Identifier: Apache-2.0
#include "hdStf/rendererPlugin.h"

#include "hdStf/renderDelegate.h"

#include "pxr/imaging/hd/rendererPluginRegistry.h"

PXR_NAMESPACE_OPEN_SCOPE

TF_REGISTRY_FUNCTION(TfType) {
    HdRendererPluginRegistry::Define<HdStfRendererPlugin>();
}

HdRenderDelegate* HdStfRendererPlugin::CreateRenderDelegate() {
    return new HdStfRenderDelegate();
}

HdRenderDelegate* HdStfRendererPlugin::CreateRenderDelegate(HdRenderSettingsMap const& settingsMap) {
    return new HdStfRenderDelegate(settingsMap);
}

void HdStfRendererPlugin::DeleteRenderDelegate(HdRenderDelegate* renderDelegate) {
    delete renderDelegate;
}

PXR_NAMESPACE_CLOSE_SCOPE
