// SPDX-License-Identifier: Apache-2.0
#include "hdStf/shaderNode.h"

#include "hdStf/tokens.h"

#include "pxr/base/plug/plugin.h"
#include "pxr/base/plug/registry.h"
#include "pxr/base/tf/diagnostic.h"
#include "pxr/base/tf/errorMark.h"
#include "pxr/base/tf/fileUtils.h"
#include "pxr/base/tf/pathUtils.h"
#include "pxr/usd/sdr/registry.h"
#if PXR_VERSION < 2211
#include "pxr/usd/ndr/discoveryPlugin.h"
#endif

#include <mutex>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

/// The definition's file; empty where the schema is not installed.
std::string _DefinitionPath() {
    const PlugPluginPtr plugin = PlugRegistry::GetInstance().GetPluginWithName("stfSchemas");
    if (!plugin) {
        return {};
    }
    const std::string path = plugin->GetResourcePath() + "/StfShell.usda";
    return TfPathExists(path) ? path : std::string();
}

#if PXR_VERSION >= 2505
using _Result = SdrShaderNodeDiscoveryResult;
using _Version = SdrVersion;
#else
using _Result = NdrNodeDiscoveryResult;
using _Version = NdrVersion;
#endif

_Result _Describe(std::string const& path) {
    TfToken const& name = HdStfNetworkTokens->StfShell;
    return _Result(name, _Version().GetAsDefault(), name.GetString(), name, TfToken("usda"), HdStfMaterialTokens->stf,
                   path, path);
}

#if PXR_VERSION < 2211
class _Discovery final : public NdrDiscoveryPlugin {
public:
    explicit _Discovery(std::string const& path) : _path(path), _folders{TfGetPathName(path)} {}
    NdrNodeDiscoveryResultVec DiscoverNodes(Context const& /*context*/) override { return {_Describe(_path)}; }
    NdrStringVec const& GetSearchURIs() const override { return _folders; }

private:
    std::string _path;
    NdrStringVec _folders;
};
#endif

void _Announce() {
    const std::string path = _DefinitionPath();
    if (path.empty()) {
        return;
    }
#if PXR_VERSION >= 2211
    SdrRegistry::GetInstance().AddDiscoveryResult(_Describe(path));
#else
    TfErrorMark errors;
    NdrRegistry::DiscoveryPluginRefPtrVec plugins;
    plugins.push_back(TfCreateRefPtr(new _Discovery(path)));
    SdrRegistry::GetInstance().SetExtraDiscoveryPlugins(std::move(plugins));
    if (!errors.IsClean()) {
        errors.Clear();
        TF_WARN("materials of StfShell nodes are not seen: the host has read shaders before hdStf was loaded; "
                "PXR_NDR_FS_PLUGIN_SEARCH_PATHS=%s PXR_NDR_FS_PLUGIN_ALLOWED_EXTS=usda in the environment tell it",
                TfGetPathName(path).c_str());
    }
#endif
}

} // namespace

void HdStfAnnounceShaderNode() {
    static std::once_flag once;
    std::call_once(once, _Announce);
}

PXR_NAMESPACE_CLOSE_SCOPE
