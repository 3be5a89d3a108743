// SPDX-License-Identifier: Apache-2.0
#include "hdStf/materialNetwork.h"

#include "hdStf/bindingReader.h"
#include "hdStf/conversions.h"
#include "hdStf/tokens.h"

#include "pxr/base/gf/vec4f.h"
#include "pxr/base/tf/pathUtils.h"
#include "pxr/imaging/hd/material.h"
#include "pxr/usd/sdf/assetPath.h"

#include <cmath>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

constexpr int _maxNodesToReader = 8; // of transforms and readers in a row

/// Reads the nodes of one network.
class _Network {
public:
    _Network(SdfPath const& id, HdMaterialNetwork const& network, HdStfMessages& messages)
        : _id(id), _network(network), _messages(messages) {}

    HdMaterialNode const* Find(SdfPath const& path) const {
        for (HdMaterialNode const& node : _network.nodes) {
            if (node.path == path) {
                return &node;
            }
        }
        return nullptr;
    }

    /// What is connected to an input; the name of the output that it comes from.
    HdMaterialNode const* Upstream(HdMaterialNode const& node, TfToken const& input, TfToken* output = nullptr) const {
        for (HdMaterialRelationship const& r : _network.relationships) {
            if (r.outputId == node.path && r.outputName == input) {
                if (output) {
                    *output = r.inputName;
                }
                return Find(r.inputId);
            }
        }
        return nullptr;
    }

    /// A parameter in the type of the fallback, which is had where there is none.
    template<class T>
    T Get(HdMaterialNode const& node, TfToken const& name, T const& fallback) const {
        const auto it = node.parameters.find(name);
        if (it == node.parameters.end()) {
            return fallback;
        }
        const VtValue value = VtValue::Cast<T>(it->second);
        if (value.IsEmpty()) {
            Complain(node, name, "has type " + it->second.GetTypeName() + ", which cannot be used");
            return fallback;
        }
        return value.template UncheckedGet<T>();
    }

    /// Tokens may arrive as text.
    std::string GetToken(HdMaterialNode const& node, TfToken const& name) const {
        const auto it = node.parameters.find(name);
        if (it == node.parameters.end()) {
            return {};
        }
        VtValue const& value = it->second;
        return value.IsHolding<TfToken>()       ? value.UncheckedGet<TfToken>().GetString()
               : value.IsHolding<std::string>() ? value.UncheckedGet<std::string>()
                                                : std::string();
    }

    void Complain(HdMaterialNode const& node, TfToken const& name, std::string const& what) const {
        _messages.Report(stf::Severity::Error,
                         _id.GetString() + ": input " + name.GetString() + " of " + node.path.GetName() + " " + what);
    }

    void Read(HdMaterialNode const& node, TfToken const& name, stf::SurfaceInput<float>* input,
              HdStfMaterialDescription* result) {
        const float value = Get(node, name, input->value);
        if (std::isfinite(value)) {
            input->value = value;
        } else {
            Complain(node, name, "is not finite; its default is used");
        }
        input->texture = _ReadConnection(node, name, result);
        if (input->texture && input->texture->channel < 0) {
            input->texture->channel = 0;
        }
    }

    void Read(HdMaterialNode const& node, TfToken const& name, stf::SurfaceInput<stf::Vec3f>* input,
              HdStfMaterialDescription* result) {
        const stf::Vec3f value = HdStfToVec3f(Get(node, name, GfVec3f(input->value.x, input->value.y, input->value.z)));
        if (stf::isFinite(value)) {
            input->value = value;
        } else {
            Complain(node, name, "is not finite; its default is used");
        }
        input->texture = _ReadConnection(node, name, result);
    }

    /// Inputs that are left out where somebody drives them.
    void LeaveOut(HdMaterialNode const& node, TfToken const& name) const {
        if (Upstream(node, name)) {
            _messages.Report(stf::Severity::Warning, _id.GetString() + ": input " + name.GetString() + " of " +
                                                         node.path.GetName() + " is not used");
        }
    }

private:
    static bool _IsReader(HdMaterialNode const& node) {
        return TfStringStartsWith(node.identifier.GetString(), "UsdPrimvarReader_");
    }

    /// The primvar that a reader names: a token, text, or what of it is connected.
    TfToken _Varname(HdMaterialNode const& reader) const {
        return TfToken(GetToken(reader, HdStfNetworkTokens->varname));
    }

    std::optional<stf::TextureMap> _ReadConnection(HdMaterialNode const& node, TfToken const& name,
                                                   HdStfMaterialDescription* result) {
        auto const& tokens = *HdStfNetworkTokens;
        TfToken output;
        HdMaterialNode const* texture = Upstream(node, name, &output);
        if (!texture) {
            return std::nullopt;
        }
        if (_IsReader(*texture) && name == tokens.diffuseColor && _Varname(*texture) == tokens.displayColor) {
            result->surface.diffuseIsDisplayColor = true;
            return std::nullopt;
        }
        if (texture->identifier != tokens.UsdUVTexture) {
            Complain(node, name,
                     "is connected to a " + texture->identifier.GetString() +
                         ", which is not read there; its value is used");
            return std::nullopt;
        }
        return _ReadTexture(*texture, output, result);
    }

    stf::TextureMap _ReadTexture(HdMaterialNode const& node, TfToken const& output, HdStfMaterialDescription* result) {
        auto const& tokens = *HdStfNetworkTokens;
        stf::TextureMap map;
        const auto file = node.parameters.find(tokens.file);
        if (file != node.parameters.end() && file->second.IsHolding<SdfAssetPath>()) {
            SdfAssetPath const& asset = file->second.UncheckedGet<SdfAssetPath>();
            map.authoredPath = asset.GetAssetPath();
            map.file = !asset.GetResolvedPath().empty()         ? asset.GetResolvedPath()
                       : TfIsRelativePath(asset.GetAssetPath()) ? std::string()
                                                                : asset.GetAssetPath();
        } else if (file != node.parameters.end() && file->second.IsHolding<std::string>()) {
            map.file = map.authoredPath = file->second.UncheckedGet<std::string>();
        }
        map.wrapS = _ToWrap(GetToken(node, tokens.wrapS));
        map.wrapT = _ToWrap(GetToken(node, tokens.wrapT));
        // From 26.02 on Hydra knows the input only as the colour space of the file.
        const std::string space = GetToken(node, tokens.sourceColorSpace);
        map.colorSpace = _ToColorSpace(space.empty() ? GetToken(node, tokens.fileColorSpace) : space);
        const auto vector = [&](TfToken const& name, stf::TextureMap::Rgba* value) {
            const GfVec4f v = Get(node, name, GfVec4f((*value)[0], (*value)[1], (*value)[2], (*value)[3]));
            for (size_t i = 0; i < 4; ++i) {
                (*value)[i] = std::isfinite(v[i]) ? v[i] : (*value)[i];
            }
        };
        vector(tokens.scale, &map.scale);
        vector(tokens.bias, &map.bias);
        vector(tokens.fallback, &map.fallback);
        std::string const& channel = output.GetString();
        map.channel = channel == "r" ? 0 : channel == "g" ? 1 : channel == "b" ? 2 : channel == "a" ? 3 : -1;
        _ReadCoordinates(node, &map, result);
        return map;
    }

    /// Names of the input, and of OpenUSD's colour spaces (GfColorSpaceNames) that stand for the same.
    static stf::TextureMap::ColorSpace _ToColorSpace(std::string const& space) {
        using ColorSpace = stf::TextureMap::ColorSpace;
        if (space == "sRGB" || space == "srgb_rec709_scene" || space == "srgb_texture") {
            return ColorSpace::Srgb;
        }
        const bool asItIs = space == "raw" || space == "data" || space == "identity" || space == "lin_rec709_scene" ||
                            space == "lin_rec709";
        return asItIs ? ColorSpace::Raw : ColorSpace::Auto;
    }

    static stf::TextureMap::Wrap _ToWrap(std::string const& wrap) {
        using Wrap = stf::TextureMap::Wrap;
        return wrap == "clamp"    ? Wrap::Clamp
               : wrap == "repeat" ? Wrap::Repeat
               : wrap == "mirror" ? Wrap::Mirror
                                  : Wrap::Black; // also useMetadata: files that hdStf reads have none
    }

    void _ReadCoordinates(HdMaterialNode const& texture, stf::TextureMap* map, HdStfMaterialDescription* result) {
        auto const& tokens = *HdStfNetworkTokens;
        HdMaterialNode const* node = Upstream(texture, tokens.st);
        bool transformed = false;
        for (int i = 0; node && i < _maxNodesToReader; ++i) {
            if (node->identifier == tokens.UsdTransform2d) {
                if (transformed) {
                    Complain(texture, tokens.st, "has several UsdTransform2d in a row; the first is used");
                } else {
                    map->uvScale = HdStfToVec2f(Get(*node, tokens.scale, GfVec2f(1.0f)));
                    map->uvTranslation = HdStfToVec2f(Get(*node, tokens.translation, GfVec2f(0.0f)));
                    map->uvRotation = Get(*node, tokens.rotation, 0.0f);
                }
                transformed = true;
                node = Upstream(*node, tokens.in);
                continue;
            }
            const TfToken primvar = _IsReader(*node) ? _Varname(*node) : TfToken();
            if (primvar.IsEmpty()) {
                Complain(texture, tokens.st,
                         "is connected to a " + node->identifier.GetString() +
                             " without a varname; the mesh's own coordinates are used");
            } else if (!result->uvPrimvar.IsEmpty() && result->uvPrimvar != primvar) {
                Complain(texture, tokens.st,
                         "reads " + primvar.GetString() + " beside " + result->uvPrimvar.GetString() +
                             "; a mesh has one set of coordinates");
            } else {
                result->uvPrimvar = primvar;
            }
            return;
        }
    }

    SdfPath const& _id;
    HdMaterialNetwork const& _network;
    HdStfMessages& _messages;
};

} // namespace

std::optional<HdStfMaterialDescription> HdStfReadMaterial(SdfPath const& id, VtValue const& resource,
                                                          HdStfMessages& messages) {
    auto const& tokens = *HdStfNetworkTokens;
    if (!resource.IsHolding<HdMaterialNetworkMap>()) {
        return std::nullopt;
    }
    HdMaterialNetworkMap const& map = resource.UncheckedGet<HdMaterialNetworkMap>();
    const auto it = map.map.find(tokens.surface);
    if (it == map.map.end() || it->second.nodes.empty()) {
        return std::nullopt;
    }
    _Network network(id, it->second, messages);
    // The terminal comes last.
    HdMaterialNode const* node = &it->second.nodes.back();
    for (SdfPath const& terminal : map.terminals) {
        HdMaterialNode const* found = network.Find(terminal);
        node = found ? found : node;
    }
    if (node->identifier == tokens.StfShell) {
        HdStfMaterialDescription result;
        HdStfBindingValues values;
        for (auto const& [name, value] : node->parameters) {
            values.emplace_back(TfToken(HdStfPrimvarTokens->prefix.GetString() + name.GetString()), value);
        }
        for (HdMaterialRelationship const& r : it->second.relationships) {
            if (r.outputId == node->path) {
                network.Complain(*node, r.outputName, "is connected to a node, which is not read there");
            }
        }
        result.shell = HdStfReadBinding(id, values, messages, HdStfBindingSource::ShaderInputs);
        if (!result.shell) {
            messages.Report(stf::Severity::Error, id.GetString() + ": StfShell has no inputs:baseVolume; meshes show "
                                                                   "their displayColor");
            return std::nullopt;
        }
        return result;
    }
    if (node->identifier != tokens.UsdPreviewSurface) {
        messages.Report(stf::Severity::Error, id.GetString() + ": its surface is a " + node->identifier.GetString() +
                                                  ", which hdStf does not know; meshes show their displayColor");
        return std::nullopt;
    }
    HdStfMaterialDescription result;
    stf::PreviewSurface& s = result.surface;
    s.useSpecularWorkflow = network.Get(*node, tokens.useSpecularWorkflow, 0) != 0;
    network.Read(*node, tokens.diffuseColor, &s.diffuseColor, &result);
    network.Read(*node, tokens.emissiveColor, &s.emissiveColor, &result);
    network.Read(*node, tokens.specularColor, &s.specularColor, &result);
    network.Read(*node, tokens.metallic, &s.metallic, &result);
    network.Read(*node, tokens.roughness, &s.roughness, &result);
    network.Read(*node, tokens.clearcoat, &s.clearcoat, &result);
    network.Read(*node, tokens.clearcoatRoughness, &s.clearcoatRoughness, &result);
    network.Read(*node, tokens.opacity, &s.opacity, &result);
    network.Read(*node, tokens.ior, &s.ior, &result);
    network.Read(*node, tokens.normal, &s.normal, &result);
    s.opacityThreshold = network.Get(*node, tokens.opacityThreshold, s.opacityThreshold);
    s.opacityIsPresence = network.GetToken(*node, tokens.opacityMode) == "presence";
    network.LeaveOut(*node, tokens.displacement);
    network.LeaveOut(*node, tokens.occlusion);
    return result;
}

PXR_NAMESPACE_CLOSE_SCOPE
